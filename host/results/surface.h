// Joints and bricks as surfaces that can be drawn: contact points with the place to which they have moved and with the
// damage of their law in the words of a reader.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// What a person wants to know of a place in a joint. Later ones hide earlier ones when points are merged.
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
};

// Displacements at any contact point, from the meshes of the blocks. Reusable for all frames of a run.
class Surfaces {
 public:
  explicit Surfaces(const Simulation& simulation);
  const Simulation::BlockMesh& mesh(int block) const { return meshes_[static_cast<size_t>(block)]; }
  std::vector<JointPoint> joint_points(const Simulation& simulation, bool own_alone = false) const;
  // Quads between neighbouring contact points of each joint, as indices of points. The mesh of joints never changes.
  const std::vector<std::array<int, 4>>& quads() const { return quads_; }

 private:
  Vec3 displacement_at(int block, const Vec3& position, const std::vector<Vec3>& displacement) const;

  std::vector<Brick> bricks_;
  std::vector<Simulation::BlockMesh> meshes_;
  std::vector<std::unordered_map<std::uint64_t, int>> gridpoint_;  // per block: by reference position
  std::vector<std::array<int, 4>> quads_;
};

}  // namespace quoin
