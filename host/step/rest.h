// The state of rest under constant loads, computed directly at the start of a stage of kind rest.
//
// Newton's method: an iteration moves blocks by the out-of-balance forces over the stiffness of zones and of closed
// points that do not slide. Laws are evaluated after each move as in a step. Steps of the stage remove the remaining
// imbalance.
#pragma once

#include <functional>

#include "step/simulation.h"

namespace quoin {

// To be called between two steps, at the start of the current stage, after require_coming_stages. Throws
// Error(interrupted) where a stop is requested between two iterations, Error(numerical) with the name of a block that
// has no support.
void find_rest(Simulation::Impl& impl, const std::function<bool()>& stop_requested);

// Throws Error(bad_input) where ranks share the model, and a stage that has not begun is of rest or has implicit
// contacts. Also for a stage of rest where the program has no sparse solver.
void require_coming_stages(const Simulation& simulation);

}  // namespace quoin
