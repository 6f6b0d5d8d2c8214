// Contact points and blocks of the lattice in a step, chunk by chunk and item by item. large_motion.h has those in
// large motion.
#pragma once

#include "base/phase_clock.h"
#include "step/state.h"

namespace quoin {

// Jumps, law and forces of a chunk. measure_step: sums for the unbalanced force and energies; report: also flags by
// contact point. clock: of the thread, started; null: not timed.
void advance_lattice_contacts(Simulation::Impl& s, int thread, int chunk, bool measure_step, bool report,
                              PhaseClock* clock);
void evaluate_law(Simulation::Impl& s, int chunk, const ChunkJumps& jump, bool measure_step, bool report);
void settle_contacts(Simulation::Impl& s);  // joints that act by the mean of the step (implicit_contacts.h)
void advance_lattice_item(Simulation::Impl& s, int thread, int item, bool measure_step);
[[noreturn]] void report_failed_points(Simulation::Impl& s);

}  // namespace quoin
