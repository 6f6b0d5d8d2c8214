// Load balancing between steps: measured work of the ranks, and repartition of blocks by it.
#pragma once

#include "step/state.h"

namespace quoin {

// Between two steps: repartitions blocks by measured costs, where that is worth its cost.
void balance_ranks(Simulation::Impl& s);
void collect_traffic(Simulation::Impl& s);

}  // namespace quoin
