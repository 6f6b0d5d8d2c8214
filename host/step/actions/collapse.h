// A body force that grows until blocks move away: the multiplier at collapse, and how the base slides when it lifts.
#pragma once

#include "step/state.h"

namespace quoin {

void find_blocks_on_base(Simulation::Impl& s);
bool collapse_ended(Simulation::Impl& s, std::vector<Warning>* warnings);

}  // namespace quoin
