// How far a model of small displacements has moved: whether its frozen geometry still describes it.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/assembly.h"

namespace quoin {

// The largest so far, and where. Indices into the assembly.
struct MotionSeen {
  double rotation = 0.0;     // rotation of a block since the start, rad
  double sliding = 0.0;      // sliding of two joined blocks over the length of their joint along the sliding
  double opening = 0.0;      // opening of a joint over its shorter side
  double translation = 0.0;  // displacement of a block since the start over the diagonal of the model
  double nearness = 0.0;     // least distance allowed for two blocks without a joint, over their current distance
  double gap = 0.0;          // distance of these two, m; < 0: depth of their overlap
  int turned_block = -1, moved_block = -1;
  int slid_joint = -1, opened_joint = -1;
  int near_block[2] = {-1, -1};
};

// Largest MotionSeen of what has no setting. A joint that has opened by its shorter side lets a block pass across by
// 1.3 % of that side if it turns by the default rotation_bound. That is less than sliding_bound allows. What has moved
// further than the model is large has left all that could hold it.
inline constexpr double kOpeningBound = 1.0, kTranslationBound = 1.0, kNearnessBound = 1.0;

Vec3 centre_of(const Brick& brick);  // m

// Small motion of a block as a whole, about its centre.
struct WholeMotion {
  Vec3 translation{}, rotation{};  // m, rad
  double speed = 0.0;              // bound of the speed of its fastest corner against the ground, m/s
};

// Displacement at an arm from the centre, m.
Vec3 at_arm(const WholeMotion& motion, const Vec3& arm);

// False where the value is within the bound; true where it is no number.
inline bool exceeds(double value, double bound) { return !(value <= bound); }

double diagonal_of(const std::vector<Brick>& bricks);  // diagonal of the box around them, m

// Of a box from the displacements of its 8 corners (x fastest, then y, then z), m. They are means over opposite faces,
// so that deformation that is the same all over the block is no rotation.
WholeMotion whole_motion(const Vec3& size, const std::array<Vec3, 8>& corner_displacement);

// Joints of an assembly, which must outlive it, with what their sliding and opening are measured by. That is kept, 0.3
// kB a block, or found again at each check.
class JointSliding {
 public:
  enum class Places { kept, recomputed };
  JointSliding() = default;
  explicit JointSliding(const Assembly& assembly, Places places = Places::kept);
  // Adds the motion of now. motion: one a brick.
  void look(const std::vector<WholeMotion>& motion, MotionSeen* seen) const;
  Vec3 centre(int joint) const { return place_of(assembly_->joints[static_cast<std::size_t>(joint)]).centre; }

 private:
  struct Place {
    int a, b;
    Vec3 arm_a, arm_b;  // centre of the joint from those of the blocks, m
    Vec3 centre;        // m
    int normal;         // axis
    double towards_b;   // along it: 1 or -1
    std::array<int, 2> along;
    std::array<double, 2> length;  // sides of the overlap, m
  };
  Place place_of(const Joint& joint) const;

  const Assembly* assembly_ = nullptr;
  double diagonal_ = 0.0;    // diagonal of the model, m
  std::vector<Place> kept_;  // or empty
};

// What is exceeded, where, by how much and what to do; empty: within the bound.
std::string past_bound(const MotionSeen& seen, const MotionBound& bound, const Assembly& assembly);

}  // namespace quoin
