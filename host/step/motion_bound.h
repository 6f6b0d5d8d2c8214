// How far a model of small displacements has moved, against the bounds within which its fixed contact geometry holds.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "scene/assembly.h"

namespace quoin {

// The largest motions so far, and where. Indices are those of the assembly.
struct MotionSeen {
  double rotation = 0.0;     // rotation of a block since the start, rad
  double sliding = 0.0;      // sliding of two joined blocks over the length of their joint along the sliding
  double opening = 0.0;      // opening of a joint over its shorter side
  double translation = 0.0;  // displacement of a block since the start over the diagonal of the model
  double sway = 0.0;         // horizontal displacements of two blocks apart, over the extent of the units along them
  double nearness = 0.0;     // least distance allowed for two blocks without a joint, over their current distance
  double gap = 0.0;          // current distance of these two blocks, m; < 0: depth of their overlap
  std::int64_t swaying_block = -1;  // with the 6 numbers below, no byte of a checkpoint is undefined
  int turned_block = -1, moved_block = -1;
  int slid_joint = -1, opened_joint = -1;
  int near_block[2] = {-1, -1};
};

// Bounds of MotionSeen without a setting. A joint that has opened by its shorter side lets a block move across by 1.3 %
// of that side if it turns by the default rotation_bound. That is less than sliding_bound allows. A block that has
// moved farther than the diagonal of the model has left all supports.
inline constexpr double kOpeningBound = 1.0, kTranslationBound = 1.0, kNearnessBound = 1.0;
// Bound of the sway over that of the rotation: 0.02 by default. The vertical load of a wall has then moved by 4 % of
// the lever arm that resists overturning. Small displacements have the lever arms of the start.
inline constexpr double kSwayOverRotation = 1.5;

Vec3 centre_of(const Brick& brick);  // m

// Small rigid motion of a block about its centre.
struct WholeMotion {
  Vec3 translation{}, rotation{};  // m, rad
  double speed = 0.0;              // bound of the speed of its fastest corner relative to the ground, m/s
};

// Displacement at an arm from the centre, m.
Vec3 at_arm(const WholeMotion& motion, const Vec3& arm);

// Time, s, in which a block moves by `way`, m, from this speed, m/s, at this acceleration, m/s2.
inline double time_for(double way, double speed, double acceleration) {
  return 2.0 * way / (speed + std::sqrt(speed * speed + 2.0 * acceleration * way));
}

// False where the value is within the bound; true for NaN.
inline bool exceeds(double value, double bound) { return !(value <= bound); }

double diagonal_of(const std::vector<Brick>& bricks);  // diagonal of the box around them, m

// Rigid motion of a box from the displacements of its 8 corners (x fastest, then y, then z), m. Means over opposite
// faces are used, so that uniform deformation gives no rotation.
WholeMotion whole_motion(const Vec3& size, const std::array<Vec3, 8>& corner_displacement);

// Joints of an assembly, with the geometry by which their sliding and opening are measured. This geometry is kept, 0.3
// kB a block, or computed again at each check. The assembly must outlive this.
class JointSliding {
 public:
  enum class Places { kept, recomputed };
  JointSliding() = default;
  explicit JointSliding(const Assembly& assembly, Places places = Places::kept);
  // Updates `seen` with the current motion. motion: one a brick. upright: axis of the weight, 0 to 2.
  void look(const std::vector<WholeMotion>& motion, MotionSeen* seen, int upright = 1) const;
  Vec3 centre(int joint) const { return place_of(assembly_->joints[static_cast<std::size_t>(joint)]).centre; }

 private:
  struct Place {
    int a, b;
    Vec3 arm_a, arm_b;  // centre of the joint from the centres of the blocks, m
    Vec3 centre;        // m
    int normal;         // axis of the joint's normal
    double towards_b;   // direction along it from a to b: 1 or -1
    std::array<int, 2> along;
    std::array<double, 2> length;  // sides of the overlap, m
  };
  Place place_of(const Joint& joint) const;

  const Assembly* assembly_ = nullptr;
  double diagonal_ = 0.0;    // diagonal of the model, m
  Vec3 extent_{};            // of blocks that are neither fixed nor beams, m
  std::vector<Place> kept_;  // Places::kept; else empty
};

// The bound that is exceeded, where, by how much and what to do; empty: none.
std::string past_bound(const MotionSeen& seen, const MotionBound& bound, const Assembly& assembly);

}  // namespace quoin
