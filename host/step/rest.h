// The state under constant loads, found directly: at the start of a stage of kind rest.
//
// Newton's method: out-of-balance forces of now, divided by the stiffness of what is closed and does not slide, move
// the blocks. Laws follow each move as they follow a step. Steps of the stage settle what is left.
#pragma once

#include "step/simulation.h"

namespace quoin {

// Between two steps, at the start of the current stage. Throws Error(bad_input) where ranks share the model or the
// program has no sparse solver; Error(numerical): a block that nothing holds, by its name.
void find_rest(Simulation::Impl& impl);

}  // namespace quoin
