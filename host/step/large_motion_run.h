// Blocks in large motion: how they are built, and what stages and steps do with them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "step/state.h"

namespace quoin {

void build_large_motion(Simulation::Impl& s, const blocks::Assembly& shapes,
                        std::vector<std::shared_ptr<const Material>> materials);
// Blocks that every rank follows through a stage, whichever rank advances them.
std::vector<int> followed_blocks(const Simulation::Impl& s);
// Before a stage is bound that names them; previous: null: it is the first.
void exchange_blocks_of_stage(Simulation::Impl& s, const Stage& settings, const Stage* previous);
std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where);
void watch_blocks(Simulation::Impl& s, const Stage& settings);  // the monitor of the stage
void begin_large_motion_stage(Simulation::Impl& s, const Stage& settings, const Stage* previous);
void swap_law_in_large_motion(Simulation::Impl& s, std::size_t index, std::shared_ptr<const Material> material);
void end_large_motion_step(Simulation::Impl& s);  // and finds contacts where blocks have moved enough
void follow_time_step(Simulation::Impl& s);       // time step of the model, which may have changed
void measure_large_motion_step(Simulation::Impl& s);
Vec3 block_translation(const Simulation::Impl& s, int block);  // displacement of the centre of mass since the start, m
Vec3 block_translation(const Simulation::Impl& s, const std::vector<int>& blocks);  // on average
// At the time of the forces of a row.
Vec3 block_translation_at_forces(const Simulation::Impl& s, const std::vector<int>& blocks);
// Rotations only: blocks in large motion may leave their joints altogether.
void check_rotations(Simulation::Impl& s);

}  // namespace quoin
