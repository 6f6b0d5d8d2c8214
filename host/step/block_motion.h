// Motion of blocks as a whole, on the lattice and in large motion, and of what rows and stages watch.
#pragma once

#include <string>
#include <vector>

#include "step/state.h"

namespace quoin {

// Blocks of a name. Of bricks rigid ones, then deformable ones, or none. Else Error(bad_input) if no block has it.
// where: place that gives it.
std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where);
const members::Members* members_of(const Simulation::Impl& s);  // null: none, or on the lattice
// Blocks whose displacement rows have and stages end by: the roof, else the monitor.
const std::vector<int>& shown_blocks(const Simulation::Impl& s);
// Displacement of the centre of mass since the start, m; of deformable bricks the mean by mass. Its velocity half a
// step before, m/s. Spin, rad/s; 0: deformable.
geometry::Vector displacement_of(const Simulation::Impl& s, int block);
geometry::Vector velocity_of(const Simulation::Impl& s, int block);
geometry::Vector spin_of(const Simulation::Impl& s, int block);
// Mean displacement of the blocks, m: current, and at the time of the last forces, one step before.
Vec3 displacement_now(const Simulation::Impl& s, const std::vector<int>& blocks);
Vec3 displacement_at_forces(const Simulation::Impl& s, const std::vector<int>& blocks);

}  // namespace quoin
