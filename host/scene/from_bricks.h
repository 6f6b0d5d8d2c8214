// Walls and buildings of bricks, converted to blocks of any shape.
#pragma once

#include <map>
#include <utility>

#include "scene/assembly.h"
#include "scene/blocks.h"

namespace quoin::blocks {

// Joint family of a pair of bricks: that of their joint. A pair without a joint has the family of the assembly's first
// bed joint.
class FamilyOfBricks {
 public:
  explicit FamilyOfBricks(const quoin::Assembly& bricks);
  int operator()(int brick_a, int brick_b) const;

 private:
  std::map<std::pair<int, int>, int> joined_;
  int others_ = 0;
};

// Adds bricks as blocks in their order and with the same zones, so that gridpoints and contact points coincide with
// those of the lattice. Rigid bricks have the names of their bodies.
void add_bricks(const quoin::Assembly& bricks, Assembly* assembly);

// Converts a wall or building alone, with its materials, families and joints, for large motion. New contacts are
// without bond.
Assembly from_bricks(const quoin::Assembly& bricks);

// ContactSettings::joint_motion of bricks: less than the size of a zone, so that contact points stay on their
// triangles.
inline constexpr double kJointMotion = 0.05;

}  // namespace quoin::blocks
