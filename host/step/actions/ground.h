// Ground motion: all fixed blocks that no table of a stage drives, and what stands on them does to them.
#pragma once

#include "step/state.h"

namespace quoin {

constexpr double kGroundAtRest = 1e-12;  // m/s, rounding of a record that ends at rest

// Velocity of the ground motion of a stage, m/s. motion: as in Drive.
geometry::Vector record_velocity(const Simulation::Impl& s, const Stage& of_stage, double time,
                                 std::int32_t motion = 0);
geometry::Vector record_since_half_step(const Simulation::Impl& s, const Stage* of_stage,
                                        std::int32_t motion);  // m/s; null: none
// On the lattice: velocity now of a body that moves with the ground, as the stage before has left it, m/s.
Vec3 left_over_velocity(const Simulation::Impl& s, const Stage* previous, int body);
// By block, its group of supports as Drive::motion has it; 0: of none.
std::vector<std::int32_t> support_groups(const Simulation::Impl& s, const Stage& settings);
void follow_ground_of_lattice(Simulation::Impl& s, double ramp);
void measure_base(const Simulation::Impl& s, HistoryRow& row);
void find_base_of_lattice(Simulation::Impl& s);

}  // namespace quoin
