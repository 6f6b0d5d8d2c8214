// A block that a stage holds, drives or loads: a brick on the lattice, or a block in large motion. Stages hold and
// drive rigid bricks alone; deformable ones they load.
#pragma once

#include <cstdint>
#include <string>

#include "step/state.h"

namespace quoin {

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
