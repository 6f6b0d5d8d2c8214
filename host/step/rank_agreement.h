// What all ranks agree on: whether they go on, what has failed, and that they have the same model.
#pragma once

#include <optional>

#include "base/error.h"
#include "step/state.h"

namespace quoin {

// All ranks throw what the first of them has found that has found anything.
void throw_together(Simulation::Impl& s, const std::optional<Error>& fault);
void begin_with_ranks(Simulation::Impl& s);
// Throws Error(bad_input): the ranks have different models. Before anything is requested that only ranks with the
// same model can exchange.
void agree_on_model(const Simulation::Impl& s);
// Whether any rank has failed. Then all has been gathered, so that rank 0 can report it.
bool agree(Simulation::Impl& s, bool trouble, bool* deviates = nullptr, bool* leaves_frame = nullptr);
bool any_rank(Simulation::Impl& s, bool here);
double largest_of_ranks(const Simulation::Impl& s, double here);

}  // namespace quoin
