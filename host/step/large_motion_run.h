// Blocks in large motion: set-up, and their part in stages and steps.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "step/state.h"

namespace quoin {

void build_large_motion(Simulation::Impl& s, const blocks::Assembly& shapes,
                        std::vector<std::shared_ptr<const Material>> materials);
// Blocks whose motion all ranks follow through a stage, whichever rank advances them.
std::vector<int> followed_blocks(const Simulation::Impl& s);
// Exchanges the motion of blocks that the stage names, before it is bound. previous: the stage before; null: there is
// none.
void exchange_blocks_of_stage(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void begin_large_motion_stage(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void swap_law_in_large_motion(Simulation::Impl& s, std::size_t index, std::shared_ptr<const Material> material);
void end_large_motion_step(Simulation::Impl& s);  // also detects contacts where blocks have moved enough
void follow_time_step(Simulation::Impl& s);       // updates the time step from that of the model
void measure_large_motion_step(Simulation::Impl& s);
// Updates the largest rotation in MotionSeen. Sliding and opening are not bounded in large motion: blocks may leave
// their joints.
void check_rotations(Simulation::Impl& s);

}  // namespace quoin
