// How even the ranks are, and the division of blocks by what they have cost.
#pragma once

#include "step/state.h"

namespace quoin {

void balance_ranks(
    Simulation::Impl& s);  // between two steps: divides blocks again where that is worth it, by measured costs
void collect_traffic(Simulation::Impl& s);

}  // namespace quoin
