#include "step/step.h"

#include <ctime>

#include "step/borders.h"
#include "step/controls.h"
#include "step/large_motion_run.h"
#include "step/lattice_step.h"
#include "step/measure.h"
#include "step/rank_agreement.h"
#include "step/run_watch.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

// Work on a chunk of contact points, or on an item. clock: of the thread, started; null: not timed.
using Work = std::function<void(int thread, int index, PhaseClock* clock)>;

// Applies actions, and chooses the measurements of the step.
void begin_step(Simulation::Impl& s, bool measure_step) {
  apply_controls(s);
  if (s.watch.pending && !s.energy.sampled) end_check(s);
  if (s.large_motion && s.energy.sampled && !s.watch.pending) s.large_motion->book_energy(true);
  if (!s.large_motion && s.energy.sampled && s.contacts.energy_columns[0].empty()) {
    for (auto& column : s.contacts.energy_columns) column.assign(static_cast<std::size_t>(s.model.point_count), 0.0);
  }
  s.data.energies = s.energy.wanted || s.energy.sampled;
  s.parts.gathered = s.parts.gathered_by_first = s.ranks == nullptr;
  s.parts.has_row = false;
  s.timing.begin_step(s.progress.step);
  if (!s.large_motion) return;
  const bool timed = s.timing.timed_steps > 0.0 && s.large_motion->held_by.members.get();
  const auto before = timed ? Clock::now() : Clock::time_point();
  s.large_motion->begin_step(measure_step);
  if (timed) s.timing.phases[Phase::members] += s.timing.timed_steps * seconds_since(before);
}

void end_step(Simulation::Impl& s, bool measure_step, bool report) {
  if (s.large_motion) end_large_motion_step(s);
  if (measure_step) {
    const auto before = Clock::now();
    sum_measurements(s);
    s.timing.phases[Phase::measurement] += seconds_since(before);
  }
  s.energy.sampled = false;
  if (report) s.lattice.flags_step = s.progress.step;
  ++s.progress.step;
  ++s.progress.stage_step;
}

// Processor time of this thread, s: it excludes other programs on the core.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void each_chunk(Simulation::Impl& s, const Work& work) {
  const auto before = s.timing.now_if_timed();
  const double evaluating = s.ranks ? processor_seconds() : 0.0;
  auto chunk = [&](int thread, int k) {
    work(thread, s.division.chunk_order[static_cast<std::size_t>(k)], s.timing.started_clock(thread));
  };
  s.pool.for_each(s.division.chunk_end, chunk);
  if (s.ranks) s.rank_load.traffic.own_seconds += processor_seconds() - evaluating;
  if (s.timing.timed_steps > 0.0) s.timing.book(seconds_since(before));
}

// With ranks items at borders are first: their motion is sent while the others move.
void each_item(Simulation::Impl& s, bool measure_step, const Work& work) {
  const auto before = s.timing.now_if_timed();
  auto on_border = [&](int thread, int k) {
    work(thread, s.division.share.items[static_cast<std::size_t>(k)], s.timing.started_clock(thread));
  };
  auto inner = [&](int thread, int k) {
    work(thread, s.division.share.items[s.division.share.border_items + static_cast<std::size_t>(k)],
         s.timing.started_clock(thread));
  };
  double moving = s.ranks ? processor_seconds() : 0.0;
  if (s.division.share.border_items > 0) s.pool.for_each(s.division.border_end, on_border);
  if (s.ranks) {
    const double sending = processor_seconds();
    send_motion(s);
    moving += processor_seconds() - sending;
  }
  s.pool.for_each(s.division.item_end, inner);
  if (s.timing.timed_steps > 0.0) s.timing.book(seconds_since(before));
  if (!s.ranks) return;
  s.rank_load.traffic.own_seconds += processor_seconds() - moving;
  receive_motion(s, measure_step);
}

}  // namespace

// One step of central differences. Displacements are those of the time t; velocities those of t - dt/2, then t + dt/2.
// Pieces of both phases are independent, so results are bitwise identical for any distribution over threads.
void step_once(Simulation::Impl& s, bool measure_step, bool report) {
  begin_step(s, measure_step);
  each_chunk(s, [&](int thread, int chunk, PhaseClock* clock) {
    if (s.large_motion) return s.large_motion->advance_contacts(chunk, clock);
    advance_lattice_contacts(s, thread, chunk, measure_step, report, clock);
  });
  const bool failed = s.contacts.law_failed.load(std::memory_order_relaxed);
  if (s.ranks && !s.large_motion ? agree(s, failed) : failed) report_failed_points(s);
  each_item(s, measure_step, [&](int thread, int item, PhaseClock* clock) {
    if (s.large_motion) return s.large_motion->advance_piece(item, clock);
    advance_lattice_item(s, thread, item, measure_step);
    lap(clock, Phase::motion);
  });
  if (s.contacts.implicit.in_use()) settle_contacts(s);
  end_step(s, measure_step, report);
}

}  // namespace quoin
