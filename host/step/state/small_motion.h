// How far blocks have moved, against the bounds of small displacements, and blocks that fall. Checks between steps
// write it; seen and next_check are saved.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "model/world.h"
#include "step/motion_bound.h"
#include "step/unjoined_blocks.h"

namespace quoin {

struct SmallMotion {
  MotionSeen seen;
  long next_check = 0;  // step of the next check
  JointSliding joint_sliding;
  UnjoinedBlocks unjoined;
  // Joint family of two blocks that meet; empty: not needed yet.
  std::function<int(const blocks::Meeting&)> meeting_family;
  std::vector<WholeMotion> whole_motions;  // by brick, at the last check
  double extent = 0.0;                     // diagonal of the model at the start, m
  std::vector<std::uint8_t> held_blocks;   // by block: bits of held components in the stage (supports.cpp)
};

}  // namespace quoin
