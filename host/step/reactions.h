// What supports, and what drives blocks, give to the joints of what they hold.
#pragma once

#include <vector>

#include "step/state.h"

namespace quoin {

// Finds the current bodies and blocks; names are those of the first time, as the history has its columns by then.
void find_restraints(Simulation::Impl& s);
void find_restrained_blocks(Simulation::Impl& s);
// Viscous forces of contacts included.
std::vector<JointWrench> sum_large_motion_wrenches(const Simulation::Impl& s, const std::vector<int>& blocks);
void measure_reactions(const Simulation::Impl& s, HistoryRow& row);

}  // namespace quoin
