// The monitor of a stage: the blocks whose displacement and force rows of the history have.
#pragma once

#include <vector>

#include "step/state.h"

namespace quoin {

// Blocks that the stage watches, by its monitor or output.monitor; none: it watches nothing. Error(bad_input): no block
// has that name, or the stage ends by displacement and watches nothing.
std::vector<int> watched_by(const Simulation::Impl& s, const Stage& settings);
void watch_blocks(Simulation::Impl& s, const Stage& settings);  // finds the monitor
Vec3 joint_force_on_monitor(const Simulation::Impl& s);         // of the last step, on the modelled part, N
// Part of that by a chunk of the lattice's points on deformable blocks.
Vec3 sum_on_monitor(const Simulation::Impl& s, int chunk);

}  // namespace quoin
