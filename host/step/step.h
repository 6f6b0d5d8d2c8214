// The step of central differences.
#pragma once

#include "step/state.h"

namespace quoin {

// Whether the sums of every step are needed for energies. Blocks in large motion sum their own.
inline bool books_energy(const Simulation::Impl& s) { return s.energy.wanted && !s.large_motion; }
// measure_step: sums for the unbalanced force and energies; report: also flags by contact point.
void step_once(Simulation::Impl& s, bool measure_step, bool report);

}  // namespace quoin
