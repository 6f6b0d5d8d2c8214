// Walls and buildings of bricks as blocks of any shape.
#pragma once

#include <map>
#include <utility>

#include "scene/assembly.h"
#include "scene/blocks.h"

namespace quoin::blocks {

// The joint families that bricks have as blocks: those of their joints. Pairs that the assembly does not join are of
// the family of its first bed joint.
class FamilyOfBricks {
 public:
  explicit FamilyOfBricks(const quoin::Assembly& bricks);
  int operator()(int brick_a, int brick_b) const;

 private:
  std::map<std::pair<int, int>, int> joined_;
  int others_ = 0;
};

// Adds bricks as blocks in their order, with the same zones: gridpoints and contact points are where the lattice has
// them. Rigid bricks carry the names of their bodies.
void add_bricks(const quoin::Assembly& bricks, Assembly* assembly);

// A wall or building alone, with its materials, families and joints, for large motion. What meets later is without
// bond.
Assembly from_bricks(const quoin::Assembly& bricks);

// ContactSettings::joint_motion of bricks: below the size of a zone, so that points still face the triangles they
// belong to.
inline constexpr double kJointMotion = 0.05;

}  // namespace quoin::blocks
