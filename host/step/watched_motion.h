// Mean motion of watched blocks, on the lattice and in large motion.
#pragma once

#include "step/state.h"

namespace quoin {

// Blocks of a name. Of bricks rigid ones, then deformable ones, or none. Else Error(bad_input) if no block has it.
// where: place that gives it.
std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where);
std::vector<int> blocks_on_lattice(const Simulation::Impl& s, const std::string& name);
std::vector<int> blocks_on_lattice(const Simulation::Impl& s, const std::string& name);
// Blocks whose displacement rows have and stages end by: the roof, else the monitor.
const std::vector<int>& shown_blocks(const Simulation::Impl& s);
// Mean displacement of the blocks, m: current, and at the time of the last forces, one step before. That of a
// deformable block is its mean by mass.
Vec3 displacement_now(const Simulation::Impl& s, const std::vector<int>& blocks);
Vec3 displacement_at_forces(const Simulation::Impl& s, const std::vector<int>& blocks);

}  // namespace quoin
