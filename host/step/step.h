// The step of central differences, and what it says when a law fails.
#pragma once

#include "step/state.h"

namespace quoin {

// By what every step measures; blocks in large motion add theirs up themselves.
inline bool books_energy(const Simulation::Impl& s) { return s.energy.wanted && !s.large_motion; }
// measure: sums for unbalanced force and energies; report: flags by contact point too.
void step_once(Simulation::Impl& s, bool measure_step, bool report);
void evaluate_law(Simulation::Impl& s, int chunk_index, const ChunkJumps& jump, bool measure_step, bool report);
[[noreturn]] void report_failed_points(Simulation::Impl& s);

}  // namespace quoin
