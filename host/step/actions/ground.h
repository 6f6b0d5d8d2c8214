// Ground motion of all fixed blocks that no table of a stage controls, and the forces of the structure on them.
#pragma once

#include <span>

#include "step/state.h"

namespace quoin {

constexpr double kGroundAtRest = 1e-12;  // m/s; rounding of a record that ends at rest

// Velocity of a stage's ground motion at `time`, m/s. motion: as in Drive.
geometry::Vector record_velocity(const Simulation::Impl& s, const Stage& of_stage, double time,
                                 std::int32_t motion = 0);
// Change of that velocity over the last half step, m/s. of_stage: null: no ground motion.
geometry::Vector record_since_half_step(const Simulation::Impl& s, const Stage* of_stage, std::int32_t motion);
// Index of the group of supports by block, as in Drive::motion; 0: none. Throws Error(bad_input): a block of a group is
// not fixed, or is in two groups.
std::vector<std::int32_t> support_groups(const Simulation::Impl& s, const Stage& settings);
// A block that moves with the ground, or has moved with that of an earlier stage and is held by this one; -1: none.
int ground_block(const Simulation::Impl& s);
// Warns of a stage that moves the ground below a model without a monitor: its rows show no response.
void warn_of_no_monitor(Simulation::Impl& s, std::vector<Warning>* warnings);
// Measures force and moment of the structure on the ground: on fixed blocks that no stage has freed, and on what lies
// below springs. supports: of Reactions::restrained_blocks.
void measure_base(const Simulation::Impl& s, std::span<const JointWrench> supports, std::span<const std::uint8_t> held,
                  HistoryRow& row);
void find_base_of_lattice(Simulation::Impl& s);

}  // namespace quoin
