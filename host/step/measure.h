// What a run reports of its step: a row of the history, energies, how far blocks have moved.
#pragma once

#include "step/state.h"

namespace quoin {

HistoryRow measure_row(const Simulation::Impl& s);
void sum_measurements(Simulation::Impl& s);                       // sums of a measured step
double largest_displacement(const Simulation::Impl& s);           // largest of the blocks that are not fixed, m
void require_finite(Simulation::Impl& s, const HistoryRow& row);  // throws Error(numerical)
Vec3 joint_force(const Simulation::Impl& s, int body);  // force of the contact points at the last law evaluation, N

}  // namespace quoin
