// Reactions of supports and of prescribed motions.
#pragma once

#include <vector>

#include "step/state.h"

namespace quoin {

// Finds the bodies or blocks of each restraint. Restraints themselves are found once, as they are columns of the
// history.
void find_restraints(Simulation::Impl& s);
void find_restrained_blocks(Simulation::Impl& s);
// Force and moment of the joints on these blocks, viscous forces included.
std::vector<JointWrench> sum_large_motion_wrenches(const Simulation::Impl& s, const std::vector<int>& blocks);
void measure_reactions(const Simulation::Impl& s, HistoryRow& row);

}  // namespace quoin
