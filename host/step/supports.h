// Supports of a stage, blocks without support, and warnings of blocks in free fall.
#pragma once

#include "step/state.h"

namespace quoin {

// Throws Error(bad_input): a stage moves the ground, and no block is fixed.
void require_moving_ground(const Simulation::Impl& s);
void warn_of_loose_blocks(Simulation::Impl& s, std::vector<Warning>* warnings);
// Warns of a block that has left all supports. Throws Error(numerical) where only equilibrium can end the stage.
void find_falling_block(Simulation::Impl& s, std::vector<Warning>* warnings);

}  // namespace quoin
