// What holds blocks in a stage, what nothing holds, and what is said of blocks that fall for ever.
#pragma once

#include "step/state.h"

namespace quoin {

// Throws Error(bad_input): a stage moves the ground, and no block is fixed.
void require_moving_ground(const Simulation::Impl& s);
void warn_of_loose_blocks(Simulation::Impl& s, std::vector<Warning>* warnings);
// Warns of a block that has left all supports. Throws Error(numerical) where the stage can only end at rest.
void find_falling_block(Simulation::Impl& s, std::vector<Warning>* warnings);

}  // namespace quoin
