#include "step/step.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "base/error.h"
#include "step/borders.h"
#include "step/controls.h"
#include "step/findings.h"
#include "step/implicit_step.h"
#include "step/large_motion_run.h"
#include "step/measure.h"
#include "step/point_kernels.h"
#include "step/rank_agreement.h"
#include "step/results.h"
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

void damp_chunk(Simulation::Impl& s, int index, const ChunkJumps& jump) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  const auto first = static_cast<std::size_t>(chunk.first_point);
  blocks::DampingColumns c{};
  for (std::size_t k = 0; k < 3; ++k) {
    c.traction[k] = s.lattice.traction[k].data() + first, c.old_traction[k] = jump.old_traction[k];
    c.viscous[k] = s.lattice.viscous[k].data() + first;
  }
  c.slip[0] = jump.slip_s, c.slip[1] = jump.slip_t;
  c.normal_jump = jump.normal, c.old_jump = s.lattice.old_jump.data() + first;
  c.area = s.model.area.data() + first;
  const auto [normal, along] = s.time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)];
  s.contacts.calls[static_cast<std::size_t>(index)].damping = damp_impacts(
      c, {}, static_cast<std::size_t>(chunk.point_count), normal / s.data.time_step, along / s.data.time_step);
}

// Jumps, law, forces of a chunk.
void advance_contacts(Simulation::Impl& s, int thread, int index, bool measure_step, bool report, PhaseClock* clock) {
  ChunkJumps* const jump = s.division.jumps[static_cast<std::size_t>(thread)].get();
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  contact_jumps(s.model, chunk, s.data, jump);
  lap(clock, Phase::jumps);
  const bool damped =
      s.lattice.damps_impacts() && s.time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)][0] > 0.0;
  const bool implicit = s.contacts.implicit.in_use();
  for (std::size_t k = 0; (damped || implicit) && k < 3; ++k)
    std::copy_n(s.lattice.traction[k].data() + chunk.first_point, chunk.point_count, jump->old_traction[k]);
  evaluate_law(s, index, *jump, measure_step, report);
  lap(clock, Phase::law);
  alignas(64) double way[kChunk];  // motion normal to the joint, for damping in the next step
  for (int i = 0; implicit && i < chunk.point_count; ++i)
    way[i] = jump->normal[i] - s.lattice.old_jump[static_cast<std::size_t>(chunk.first_point + i)];
  if (damped) damp_chunk(s, index, *jump);
  if (implicit) weigh_chunk(s, index, *jump, way);
  const double* const of_damping[3] = {s.lattice.viscous[0].data(), s.lattice.viscous[1].data(),
                                       s.lattice.viscous[2].data()};
  contact_forces(s.model, chunk, s.data, damped ? of_damping : nullptr);
  lap(clock, Phase::contact_forces);
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
    work(thread, s.division.share.chunks[static_cast<std::size_t>(k)], s.timing.started_clock(thread));
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

void advance_item(Simulation::Impl& s, int thread, int item, bool measure_step) {
  double* const memory = s.division.scratch[static_cast<std::size_t>(thread)].data();
  Measured* const record = measure_step ? &s.division.measured[static_cast<std::size_t>(item)] : nullptr;
  auto i = static_cast<std::size_t>(item);
  if (i < s.model.unit_groups.size()) return advance_units(s.model, s.model.unit_groups[i], s.data, memory, record);
  i -= s.model.unit_groups.size();
  if (s.lattice.bodies[i].at_rest) {
    if (record) *record = {};
    return;
  }
  if (i < s.model.body_groups.size())
    return advance_bodies(s.model, s.model.body_groups[i], s.inertia.of_body_group[i], s.data, &s.lattice.bodies[i],
                          record);
  const auto b = static_cast<std::size_t>(s.model.lone_bodies[i - s.model.body_groups.size()]);
  advance_body(s.model.bodies[b], s.inertia.in_use.body_mass[b], s.inertia.in_use.body_inertia[b], s.data,
               &s.lattice.bodies[i], record);
}

}  // namespace

// One step of central differences. Displacements are those of the time t; velocities those of t - dt/2, then t + dt/2.
// Pieces of both phases are independent, so results are bitwise identical for any distribution over threads.
void step_once(Simulation::Impl& s, bool measure_step, bool report) {
  begin_step(s, measure_step);
  each_chunk(s, [&](int thread, int chunk, PhaseClock* clock) {
    if (s.large_motion) return s.large_motion->advance_contacts(chunk, clock);
    advance_contacts(s, thread, chunk, measure_step, report, clock);
  });
  const bool failed = s.contacts.law_failed.load(std::memory_order_relaxed);
  if (s.ranks && !s.large_motion ? agree(s, failed) : failed) report_failed_points(s);
  each_item(s, measure_step, [&](int thread, int item, PhaseClock* clock) {
    if (s.large_motion) return s.large_motion->advance_piece(item, clock);
    advance_item(s, thread, item, measure_step);
    lap(clock, Phase::motion);
  });
  if (s.contacts.implicit.in_use()) settle_contacts(s);
  end_step(s, measure_step, report);
}

void evaluate_law(Simulation::Impl& s, int chunk_index, const ChunkJumps& jump, bool measure_step, bool report) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(chunk_index)];
  const ContactFamily& family = s.model.families[static_cast<std::size_t>(chunk.family)];
  LawCall& call = s.contacts.calls[static_cast<std::size_t>(chunk_index)];
  quoin_batch& batch = call.batch;
  batch.normal_jump = {jump.normal, 1};
  batch.slip_increment[0] = {jump.slip_s, 1};
  batch.slip_increment[1] = {jump.slip_t, 1};
  const std::uint64_t capabilities = family.material->api().capabilities;
  batch.flags = {report && (capabilities & QUOIN_CAN_FLAGS) ? s.lattice.flags.data() + chunk.first_point : nullptr, 1};
  const bool energies_too = s.energy.sampled && (capabilities & QUOIN_CAN_ENERGY);
  if (energies_too) s.contacts.bind_energies(call, chunk);
  const quoin_status status = family.material->evaluate(&batch);
  if (status != QUOIN_OK || batch.failed_count != 0) {
    call.failed = true;
    call.status = status;
    s.contacts.law_failed.store(true, std::memory_order_relaxed);
  }
  if (!measure_step) return;

  call.crushed_out = 0;
  for (int i = chunk.first_point; report && i < chunk.first_point + chunk.point_count; ++i)
    call.crushed_out += condition_of(s.lattice.flags[static_cast<std::size_t>(i)]) == Condition::crushed_out;
  call.force_sum = call.stored = 0.0;
  call.dissipated = {};
  call.deepest = 0.0;
  for (int i = chunk.first_point; i < chunk.first_point + chunk.point_count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    call.force_sum += s.model.area[p] * std::sqrt(s.lattice.traction[0][p] * s.lattice.traction[0][p] +
                                                  s.lattice.traction[1][p] * s.lattice.traction[1][p] +
                                                  s.lattice.traction[2][p] * s.lattice.traction[2][p]);
    if (const double opening = jump.normal[i - chunk.first_point]; opening < call.deepest)
      call.deepest = opening, call.deepest_point = i;
    if (!batch.energy_stored.data) continue;
    call.stored += s.model.area[p] * s.contacts.energy_columns[0][p];
    for (std::size_t k = 0; k < 4; ++k) call.dissipated[k] += s.model.area[p] * s.contacts.energy_columns[k + 1][p];
  }
  if (!energies_too) return;
  batch.energy_stored = {};
  for (auto& column : batch.dissipated) column = {};
}

void report_failed_points(Simulation::Impl& s) {
  for (std::size_t c = 0; c < s.contacts.calls.size(); ++c) {
    LawCall& call = s.contacts.calls[c];
    if (!call.failed) continue;
    const ContactChunk& chunk = s.model.chunks[c];
    const ContactFamily& family = s.model.families[static_cast<std::size_t>(chunk.family)];
    const std::string law = family.material->api().id;
    if (const std::string fault = family.material->fault(); !fault.empty())
      throw Error(Exit::numerical, fmt::format("step {}, {}: {}", s.progress.step, batch_text(s, call.batch), fault));
    if (call.status != QUOIN_OK) {
      throw Error(Exit::numerical,
                  fmt::format("law '{}' of joint family '{}' refused a batch with status {} at step {}", law,
                              family.name, call.status, s.progress.step));
    }
    // Failed points keep their old state: a second call, now with the status by point, fails at the same ones.
    ChunkJumps jump;
    contact_jumps(s.model, chunk, s.data, &jump);
    std::vector<std::uint32_t> point_status(kChunk, QUOIN_POINT_OK);
    call.batch.normal_jump = {jump.normal, 1};
    call.batch.slip_increment[0] = {jump.slip_s, 1};
    call.batch.slip_increment[1] = {jump.slip_t, 1};
    call.batch.status = {point_status.data(), 1};
    family.material->evaluate(&call.batch);
    call.batch.status = {};
    for (std::size_t i = 0; i < static_cast<std::size_t>(chunk.point_count); ++i) {
      if (point_status[i] != QUOIN_POINT_FAILED) continue;
      const std::size_t p = static_cast<std::size_t>(chunk.first_point) + i;
      const Vec3& x = s.model.point_position[p];
      const Joint& joint = s.model.assembly.joints[static_cast<std::size_t>(s.model.point_joint[p])];
      throw Error(
          Exit::numerical,
          fmt::format("law '{}' failed at step {}, time {:.6g} s: joint {} (family '{}', blocks {} and {}), contact "
                      "point at ({:.4f}, {:.4f}, {:.4f}) m, opening {:.6g} m, slip in the step ({:.6g}, {:.6g}) m, "
                      "traction ({:.6g}, {:.6g}, {:.6g}) Pa. A smaller solver.time_step_fraction than {:g} may help",
                      law, s.progress.step, time_now(s), s.model.point_joint[p], family.name, joint.block_a,
                      joint.block_b, x[0], x[1], x[2], jump.normal[i], jump.slip_s[i], jump.slip_t[i],
                      s.lattice.traction[0][p], s.lattice.traction[1][p], s.lattice.traction[2][p],
                      s.scene.solver.time_step_fraction));
    }
    throw Error(Exit::numerical,
                fmt::format("law '{}' says at step {} that {} points failed, and names none: {}; tell its author", law,
                            s.progress.step, call.batch.failed_count, batch_text(s, call.batch)));
  }
  throw Error(Exit::numerical, fmt::format("a law failed at step {}", s.progress.step));
}

std::string batch_text(const Simulation::Impl& s, const quoin_batch& batch) {
  for (std::size_t c = 0; c < s.contacts.calls.size(); ++c) {
    if (&s.contacts.calls[c].batch != &batch) continue;
    const ContactChunk& chunk = s.model.chunks[c];
    const Vec3& x = s.model.point_position[static_cast<std::size_t>(chunk.first_point)];
    return fmt::format("contact points {} to {} of joint family '{}', from ({:.3f}, {:.3f}, {:.3f}) m on",
                       chunk.first_point, chunk.first_point + chunk.point_count - 1,
                       s.model.families[static_cast<std::size_t>(chunk.family)].name, x[0], x[1], x[2]);
  }
  return s.large_motion ? s.large_motion->batch_text(batch) : fmt::format("a batch of {} points", batch.count);
}

}  // namespace quoin
