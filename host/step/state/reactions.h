// Whose joints are summed for what supports and drives give. Found from the model and all stages before the first; the
// sums are written before a row by the rank that has the block.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "scene/assembly.h"
#include "step/simulation.h"

namespace quoin {

// Force and moment of the joints of a rigid body, or a block, for a row of the history.
struct JointWrench {
  Vec3 force{};             // N
  Vec3 moment{}, centre{};  // about its centre at the start, N m; where that is, m
  Vec3 displacement{};      // displacement since the start, m
};

struct Reactions {
  std::vector<Restraint> restraints;
  bool restraints_found = false;
  std::vector<int> restraint_of;                     // by body, or by block: index into restraints; -1: none
  std::vector<int> restrained_blocks;                // blocks in large motion that are fixed, or held by some stage
  std::vector<std::vector<int>> restrained_of_item;  // the same by item, with ranks
  std::vector<JointWrench> body_wrench;              // by body, of the last row; with ranks
  std::vector<JointWrench> block_wrench;  // wrenches of restrained_blocks in the last row, by block; with ranks
  std::vector<std::uint8_t> on_base;      // by block: a free one that rests on fixed ones at the start
  geometry::Vector base_centre;           // centre of the area between these at the start, m
};

}  // namespace quoin
