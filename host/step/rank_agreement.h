// Agreement of all ranks: whether they continue, what has failed, and that they have the same model.
#pragma once

#include "step/state.h"

namespace quoin {

void begin_with_ranks(Simulation::Impl& s);
// Throws Error(bad_input): the ranks have different models. To be called before exchanges that need equal models.
void agree_on_model(const Simulation::Impl& s);
// Whether any rank has failed. All is then gathered on rank 0, which reports it. Also agrees on stops, on contact
// detection that is due, and on blocks that leave their frames.
bool agree(Simulation::Impl& s, bool trouble, bool* deviates = nullptr, bool* leaves_frame = nullptr);
bool any_rank(Simulation::Impl& s, bool here);
void note_waiting(Simulation::Impl& s, Clock::time_point since);  // adds to the times of this rank
double largest_of_ranks(const Simulation::Impl& s, double here);

}  // namespace quoin
