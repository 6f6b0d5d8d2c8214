// Blocks by number, as bricks on the lattice or in large motion: their motion, and what rows and stages watch of it.
// And how stages hold, drive and load them. Stages hold and drive rigid bricks alone; deformable ones they load.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "step/state.h"

namespace quoin {

namespace members {
struct Bed;
}

// Blocks of a name. Of bricks rigid ones, then deformable ones, or none. Else Error(bad_input) if no block has it.
// where: place that gives it.
std::vector<int> blocks_named(const Simulation::Impl& s, const std::string& name, const std::string& where);
const members::Members* members_of(const Simulation::Impl& s);     // null: none, or on the lattice
std::span<const members::Bed> beds_of(const Simulation::Impl& s);  // faces on springs
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

const std::string& name_in_stages(const Simulation::Impl& s, int block);  // empty: none
bool is_rigid(const Simulation::Impl& s, int block);
bool is_fixed(const Simulation::Impl& s, int block);  // by the scene; of bricks rigid ones
// Sum of the forces of joints, weight and loads on a rigid block, N. What is held has the opposite from its support.
geometry::Vector net_force(const Simulation::Impl& s, int block);
// The same of moments about the centre of mass, N m, of deformable blocks too.
geometry::Vector net_moment(const Simulation::Impl& s, int block);
// Prescribes velocities, m/s and rad/s, along the held components (bits of Drive::held). Kinetic energy of what it
// catches or releases is booked as work.
void prescribe(Simulation::Impl& s, int block, const geometry::Vector& velocity, const geometry::Vector& omega,
               std::uint8_t held);
// Sets the force at the centre of mass, N, and the moment about it, N m. They act until they are set again or the stage
// ends.
void apply_force(Simulation::Impl& s, int block, const geometry::Vector& force, const geometry::Vector& moment = {});
void remove_forces(Simulation::Impl& s);  // of all blocks

}  // namespace quoin
