// The state of rest under constant loads, computed directly at the start of a stage of kind rest.
//
// Newton's method: an iteration moves blocks by the out-of-balance forces over the stiffness of zones and of closed
// points that do not slide. Laws are evaluated after each move as in a step. Steps of the stage remove the remaining
// imbalance.
#pragma once

#include <functional>

#include "step/simulation.h"

namespace quoin {

// To be called between two steps, at the start of the current stage, after require_rest. Throws Error(interrupted)
// where a stop is requested between two iterations, Error(numerical) with the name of a block that has no support.
void find_rest(Simulation::Impl& impl, const std::function<bool()>& stop_requested);

// Throws Error(bad_input) where the stage is of rest, and ranks share the model or the program has no sparse solver.
void require_rest(const Simulation::Impl& impl, int stage);

}  // namespace quoin
