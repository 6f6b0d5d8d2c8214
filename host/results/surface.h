// Joints and bricks as surfaces that can be drawn. Contact points have the place to which they have moved, and their
// law's damage in the words of a reader.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "step/results.h"
#include "step/simulation.h"

namespace quoin {

// Numbers that a page shows of a place in a joint. Later ones hide earlier ones when points are merged.
enum class Crack : std::uint8_t { intact, sliding_begun, opening_begun, slipped, open, crushed };
inline constexpr int kCrackCount = 6;

struct JointPoint {
  ContactPoint contact;
  Vec3 displacement;    // mean of the two sides, m; 0 for blocks of any shape, whose points are given where they stand
  Vec3 side_a, side_b;  // displacements of the two sides, m
  double opening;       // m
  double slip;          // plastic slip where the law keeps it, otherwise the sliding jump, m
  double damage_tension,
      damage_shear;  // share of tensile strength and cohesion lost; 0.5 begun, where nothing says more
  double closure;    // plastic closure by crushing, m
  Crack crack;
  Vec3 gap{};  // where blocks have come apart in large motion: from its place on block a to that on block b, m; else 0
};

// What the law of a contact point says of it; NaN: nothing.
struct LawView {
  std::array<double, QUOIN_DAMAGE_COUNT> damage;
  double slip, closure;  // m
};
JointPoint joint_point(const Simulation& simulation, const ContactPoint& contact, const LawView& law);

// Contact points of the lattice that this rank has, joint after joint.
std::vector<std::int32_t> points_by_joint(const Simulation& simulation);

// Surfaces of joints. Reusable for all frames of a model.
class Surfaces {
 public:
  std::vector<JointPoint> joint_points(const Simulation& simulation, const PointRange& range,
                                       bool own_alone = false) const;
  std::vector<JointPoint> joint_points(const Simulation& simulation) const {
    return joint_points(simulation, all_points(simulation));
  }
  // Quads between neighbouring contact points of each joint on the lattice, as indices of points; of those points that
  // this rank has, joint after joint. The mesh of joints never changes.
  using Quad = std::array<int, 4>;
  const std::vector<Quad>& quads(const Simulation& simulation) const;
  std::span<const Quad> quads_of_joints(const Simulation& simulation, int first, int end) const;  // joints [first, end)

 private:
  mutable std::vector<Quad> quads_;
  mutable long of_layout_ = -1;  // Model::layouts
};

}  // namespace quoin
