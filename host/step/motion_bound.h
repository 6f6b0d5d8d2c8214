// How far a model of small displacements has moved: whether its frozen geometry still describes it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/assembly.h"

namespace quoin {

// The largest so far, and where.
struct MotionSeen {
  double rotation = 0.0;  // of a block since the start, rad
  double sliding = 0.0;   // of two joined blocks on each other over the length of their joint along the sliding
  int turned_block = -1;  // index into the assembly
  int slid_joint = -1;
};

Vec3 centre_of(const Brick& brick);  // m

// Small motion of a block as a whole, about its centre.
struct WholeMotion {
  Vec3 translation{}, rotation{};  // m, rad
};

// Of a box from the displacements of its 8 corners (x fastest, then y, then z), m: means over opposite faces, so that
// deformation that is the same all over the block is no rotation.
WholeMotion whole_motion(const Vec3& size, const std::array<Vec3, 8>& corner_displacement);

// The joints of an assembly, which must outlive it, with what their sliding is measured by: kept, which is 0.3 kB a
// block, or found anew at each look.
class JointSliding {
 public:
  enum class Places { kept, found_anew };
  JointSliding() = default;
  explicit JointSliding(const Assembly& assembly, Places places = Places::kept);
  // Adds the motion of now. motion: one a brick.
  void look(const std::vector<WholeMotion>& motion, MotionSeen* seen) const;
  Vec3 centre(int joint) const { return place_of(assembly_->joints[static_cast<std::size_t>(joint)]).centre; }

 private:
  struct Place {
    int a, b;
    Vec3 arm_a, arm_b;  // of the joint's centre from those of the blocks, m
    Vec3 centre;        // m
    std::array<int, 2> along;
    std::array<double, 2> length;  // of the overlap, m
  };
  Place place_of(const Joint& joint) const;

  const Assembly* assembly_ = nullptr;
  std::vector<Place> kept_;  // or empty
};

// What is exceeded, where, by how much and what to do; empty: within the bound.
std::string past_bound(const MotionSeen& seen, const MotionBound& bound, const Assembly& assembly);

}  // namespace quoin
