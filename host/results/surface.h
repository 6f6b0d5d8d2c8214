// Joints and bricks as surfaces for drawings: contact points with their displacement and the damage of their law.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "step/results.h"
#include "step/simulation.h"

namespace quoin {

// States of a joint in pictures. The later one is shown where points coincide.
enum class Crack : std::uint8_t { intact, sliding_begun, opening_begun, slipped, open, crushed };
inline constexpr int kCrackCount = 6;

struct JointPoint {
  ContactPoint contact;
  Vec3 displacement;    // mean of the two sides, m; 0 for blocks of any shape, whose points are in their current places
  Vec3 side_a, side_b;  // displacements of the two sides, m
  double opening;       // m
  double slip;          // plastic slip of the law, or the slip of the contact if the law has none, m
  double damage_tension,
      damage_shear;  // lost share of tensile strength and of cohesion; 0.5: begun, by flags alone
  double closure;    // plastic closure by crushing, m
  Crack crack;
  // Vector from its place on block a to that on block b where blocks have parted in large motion, m; else 0.
  Vec3 gap{};
};

// Results of a law at a contact point; NaN: the law has none.
struct LawView {
  std::array<double, QUOIN_DAMAGE_COUNT> damage;
  double slip, closure;  // m
};
JointPoint joint_point(const Simulation& simulation, const ContactPoint& contact, const LawView& law);

// Contact points of the lattice on this rank, joint by joint.
std::vector<std::int32_t> points_by_joint(const Simulation& simulation);

// Surfaces of joints. One object serves all frames of a model.
class Surfaces {
 public:
  std::vector<JointPoint> joint_points(const Simulation& simulation, const PointRange& range,
                                       bool own_alone = false) const;
  std::vector<JointPoint> joint_points(const Simulation& simulation) const {
    return joint_points(simulation, all_points(simulation));
  }
  // Quads between neighbouring contact points of each joint on the lattice, as indices of points. They are those of
  // this rank's points, joint by joint. The mesh of joints never changes.
  using Quad = std::array<int, 4>;
  const std::vector<Quad>& quads(const Simulation& simulation) const;
  std::span<const Quad> quads_of_joints(const Simulation& simulation, int first, int end) const;  // joints [first, end)

 private:
  mutable std::vector<Quad> quads_;
  mutable long of_layout_ = -1;  // Model::layouts of quads_
};

}  // namespace quoin
