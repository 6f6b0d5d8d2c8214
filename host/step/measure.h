// Measurements of a step: a row of the history, energies, how far blocks have moved.
#pragma once

#include "step/state.h"

namespace quoin {

HistoryRow measure_row(const Simulation::Impl& s);
void sum_measurements(Simulation::Impl& s);                       // sums over items and chunks of a measured step
void require_finite(Simulation::Impl& s, const HistoryRow& row);  // throws Error(numerical)

}  // namespace quoin
