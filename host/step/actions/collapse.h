// A body force that grows until blocks move away. It gives the collapse multiplier, and the slip of the base at uplift.
#pragma once

#include "step/state.h"

namespace quoin {

// Finds the blocks that rest on fixed ones, and the centre of their joints.
void find_blocks_on_base(Simulation::Impl& s);
// Whether the collapse stage has ended, after a check of displacements and loads. All ranks call it.
bool collapse_ended(Simulation::Impl& s, std::vector<Warning>* warnings);

}  // namespace quoin
