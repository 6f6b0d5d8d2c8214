// Supports and prescribed motions whose reactions are in the history. They are found once, from the model and all
// stages. Each rank sums the forces of its own blocks before a row.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "scene/assembly.h"
#include "step/simulation.h"

namespace quoin {

// Force and moment of the joints on a rigid body, or on a block, for a row of the history.
struct JointWrench {
  Vec3 force{};             // N
  Vec3 moment{}, centre{};  // moment about the centre at the start, N m; that centre, m
  Vec3 displacement{};      // displacement since the start, m
};

struct Reactions {
  std::vector<Restraint> restraints;
  bool restraints_found = false;
  std::vector<int> restraint_of;                     // by block: index into restraints; -1: none
  std::vector<int> restrained_blocks;                // blocks that are fixed, or held in some stage
  std::vector<std::vector<int>> restrained_of_item;  // restrained blocks by item, with ranks
  // By block, in the last row: of rigid bricks, or of restrained_blocks in large motion. With ranks.
  std::vector<JointWrench> wrench;
  std::vector<std::uint8_t> on_base;  // by block: 1: it rests on a fixed block at the start
  geometry::Vector base_centre;       // area centre of the bed joints on fixed blocks, and of springs, at the start, m
};

}  // namespace quoin
