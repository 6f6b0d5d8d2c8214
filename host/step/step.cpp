// The step of central differences, and what it says when a law fails.
#include <fmt/core.h>

#include <cmath>
#include <cstring>
#include <ctime>

#include "step/point_kernels.h"
#include "step/state.h"

namespace quoin {

namespace {

// Of this thread, s: what others take of the core is no cost of a block.
double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

// One step of central differences. Displacements are those of the time t; velocities those of t - dt/2, then t + dt/2.
// Both phases go over independent pieces, so the bits do not depend on which thread does which.
void Simulation::Impl::step_once(bool measure_step, bool report) {
  begin_step(measure_step);
  each_chunk([&](int thread, int chunk, PhaseClock* clock) {
    if (large_motion) return large_motion->advance_contacts(chunk, clock);
    advance_contacts(thread, chunk, measure_step, report, clock);
  });
  const bool failed = law_failed.load(std::memory_order_relaxed);
  if (ranks && !large_motion ? agree(failed) : failed) report_failed_points();
  each_item(measure_step, [&](int thread, int item, PhaseClock* clock) {
    if (large_motion) return large_motion->advance_piece(item, clock);
    advance_item(thread, item, measure_step);
    lap(clock, Phase::motion);
  });
  if (implicit_contacts.in_use()) settle_contacts();
  end_step(measure_step, report);
}

// What acts from outside, and what the step is asked for.
void Simulation::Impl::begin_step(bool measure_step) {
  apply_controls();
  if (watch.pending && !sample_energy) end_check();
  if (large_motion && sample_energy && !watch.pending) large_motion->book_energy(true);
  if (!large_motion && sample_energy && energy_columns[0].empty()) {
    for (auto& column : energy_columns) column.assign(static_cast<std::size_t>(model.point_count), 0.0);
  }
  data.energies = want_energy || sample_energy;
  gathered = gathered_by_first = ranks == nullptr;
  has_row = false;
  timed_steps = time_every_step ? 1.0 : step_count % kTimedSteps == 0 ? static_cast<double>(kTimedSteps) : 0.0;
  if (!large_motion) return;
  const bool timed = timed_steps > 0.0 && large_motion->members();
  const auto before = timed ? Clock::now() : Clock::time_point();
  large_motion->begin_step(measure_step);
  if (timed) times[Phase::members] += timed_steps * seconds_since(before);
}

// Jumps, law, forces.
void Simulation::Impl::advance_contacts(int thread, int index, bool measure_step, bool report, PhaseClock* clock) {
  ChunkJumps* const jump = jumps[static_cast<std::size_t>(thread)].get();
  const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(index)];
  contact_jumps(model, chunk, data, jump);
  lap(clock, Phase::jumps);
  const bool damped = damps_impacts() && time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)][0] > 0.0;
  const bool implicit = implicit_contacts.in_use();
  for (std::size_t k = 0; (damped || implicit) && k < 3; ++k)
    std::copy_n(traction[k].data() + chunk.first_point, chunk.point_count, jump->old_traction[k]);
  evaluate_law(index, *jump, measure_step, report);
  lap(clock, Phase::law);
  alignas(64) double way[kChunk];  // normal to the joint, before damping looks at the next step
  for (int i = 0; implicit && i < chunk.point_count; ++i)
    way[i] = jump->normal[i] - old_jump[static_cast<std::size_t>(chunk.first_point + i)];
  if (damped) damp_chunk(index, *jump);
  if (implicit) weigh_chunk(index, *jump, way);
  const double* const of_damping[3] = {viscous[0].data(), viscous[1].data(), viscous[2].data()};
  contact_forces(model, chunk, data, damped ? of_damping : nullptr);
  lap(clock, Phase::contact_forces);
}

void Simulation::Impl::end_step(bool measure_step, bool report) {
  if (large_motion) end_large_motion_step(timed_steps);
  if (measure_step) {
    const auto before = Clock::now();
    sum_measurements();
    times[Phase::measurement] += seconds_since(before);
  }
  sample_energy = false;
  if (report) flags_step = step_count;
  ++step_count;
  ++stage_step;
}

PhaseClock* Simulation::Impl::started_clock(int thread) {
  if (timed_steps == 0.0) return nullptr;
  PhaseClock& clock = clocks[static_cast<std::size_t>(thread)];
  clock.start();
  return &clock;
}

void Simulation::Impl::each_chunk(const Work& work) {
  const auto before = timed_steps > 0.0 ? Clock::now() : Clock::time_point();
  const double evaluating = ranks ? processor_seconds() : 0.0;
  auto chunk = [&](int thread, int k) {
    work(thread, share.chunks[static_cast<std::size_t>(k)], started_clock(thread));
  };
  pool.for_each(chunk_end, chunk);
  if (ranks) traffic.own_seconds += processor_seconds() - evaluating;
  if (timed_steps > 0.0) book_time(seconds_since(before), timed_steps);
}

// With ranks those on borders first: what others wait for is on its way while the rest moves.
void Simulation::Impl::each_item(bool measure_step, const Work& work) {
  const auto before = timed_steps > 0.0 ? Clock::now() : Clock::time_point();
  auto on_border = [&](int thread, int k) {
    work(thread, share.items[static_cast<std::size_t>(k)], started_clock(thread));
  };
  auto inner = [&](int thread, int k) {
    work(thread, share.items[share.border_items + static_cast<std::size_t>(k)], started_clock(thread));
  };
  double moving = ranks ? processor_seconds() : 0.0;
  if (share.border_items > 0) pool.for_each(border_end, on_border);
  if (ranks) {
    const double sending = processor_seconds();
    send_motion();
    moving += processor_seconds() - sending;
  }
  pool.for_each(item_end, inner);
  if (timed_steps > 0.0) book_time(seconds_since(before), timed_steps);
  if (!ranks) return;
  traffic.own_seconds += processor_seconds() - moving;
  receive_motion(measure_step);
}

void Simulation::Impl::book_time(double wall, double weight) {
  PhaseTimes sum;
  double total = 0.0;
  for (PhaseClock& clock : clocks) {
    for (std::size_t k = 0; k < kPhases; ++k) sum.seconds[k] += clock.times.seconds[k], total += clock.times.seconds[k];
    clock.times = {};
  }
  for (std::size_t k = 0; k < kPhases && total > 0.0; ++k) times.seconds[k] += weight * wall * sum.seconds[k] / total;
}

void Simulation::Impl::advance_item(int thread, int item, bool measure_step) {
  double* const memory = scratch[static_cast<std::size_t>(thread)].data();
  Measured* const record = measure_step ? &measured[static_cast<std::size_t>(item)] : nullptr;
  auto i = static_cast<std::size_t>(item);
  if (i < model.unit_groups.size()) return advance_units(model, model.unit_groups[i], data, memory, record);
  i -= model.unit_groups.size();
  if (body_lanes[i].at_rest) {
    if (record) *record = {};
    return;
  }
  if (i < model.body_groups.size())
    return advance_bodies(model, model.body_groups[i], group_inertia[i], data, &body_lanes[i], record);
  const auto b = static_cast<std::size_t>(model.lone_bodies[i - model.body_groups.size()]);
  advance_body(model.bodies[b], inertia.body_mass[b], inertia.body_inertia[b], data, &body_lanes[i], record);
}

void Simulation::Impl::damp_chunk(int index, const ChunkJumps& jump) {
  const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(index)];
  const auto first = static_cast<std::size_t>(chunk.first_point);
  blocks::DampingColumns c{};
  for (std::size_t k = 0; k < 3; ++k) {
    c.traction[k] = traction[k].data() + first, c.old_traction[k] = jump.old_traction[k];
    c.viscous[k] = viscous[k].data() + first;
  }
  c.slip[0] = jump.slip_s, c.slip[1] = jump.slip_t;
  c.normal_jump = jump.normal, c.old_jump = old_jump.data() + first;
  c.area = model.area.data() + first;
  const auto [normal, along] = time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)];
  calls[static_cast<std::size_t>(index)].damping =
      damp_impacts(c, {}, static_cast<std::size_t>(chunk.point_count), normal / data.time_step, along / data.time_step);
}

void Simulation::Impl::evaluate_law(int chunk_index, const ChunkJumps& jump, bool measure_step, bool report) {
  const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(chunk_index)];
  const ContactFamily& family = model.families[static_cast<std::size_t>(chunk.family)];
  LawCall& call = calls[static_cast<std::size_t>(chunk_index)];
  quoin_batch& batch = call.batch;
  batch.normal_jump = {jump.normal, 1};
  batch.slip_increment[0] = {jump.slip_s, 1};
  batch.slip_increment[1] = {jump.slip_t, 1};
  const std::uint64_t capabilities = family.material->api().capabilities;
  batch.flags = {report && (capabilities & QUOIN_CAN_FLAGS) ? flags.data() + chunk.first_point : nullptr, 1};
  const bool energies_too = sample_energy && (capabilities & QUOIN_CAN_ENERGY);
  if (energies_too) bind_energies(call, chunk);
  const quoin_status status = family.material->evaluate(&batch);
  if (status != QUOIN_OK || batch.failed_count != 0) {
    call.failed = true;
    call.status = status;
    law_failed.store(true, std::memory_order_relaxed);
  }
  if (!measure_step) return;

  call.crushed_out = 0;
  for (int i = chunk.first_point; report && i < chunk.first_point + chunk.point_count; ++i)
    call.crushed_out += condition_of(flags[static_cast<std::size_t>(i)]) == Condition::crushed_out;
  call.force_sum = call.stored = 0.0;
  call.dissipated = {};
  call.deepest = 0.0;
  for (int i = chunk.first_point; i < chunk.first_point + chunk.point_count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    call.force_sum += model.area[p] * std::sqrt(traction[0][p] * traction[0][p] + traction[1][p] * traction[1][p] +
                                                traction[2][p] * traction[2][p]);
    if (const double opening = jump.normal[i - chunk.first_point]; opening < call.deepest)
      call.deepest = opening, call.deepest_point = i;
    if (!batch.energy_stored.data) continue;
    call.stored += model.area[p] * energy_columns[0][p];
    for (std::size_t k = 0; k < 4; ++k) call.dissipated[k] += model.area[p] * energy_columns[k + 1][p];
  }
  if (!energies_too) return;
  batch.energy_stored = {};
  for (auto& column : batch.dissipated) column = {};
}

void Simulation::Impl::report_failed_points() {
  for (std::size_t c = 0; c < calls.size(); ++c) {
    LawCall& call = calls[c];
    if (!call.failed) continue;
    const ContactChunk& chunk = model.chunks[c];
    const ContactFamily& family = model.families[static_cast<std::size_t>(chunk.family)];
    const std::string law = family.material->api().id;
    if (const std::string fault = family.material->fault(); !fault.empty())
      throw Error(Exit::numerical, fmt::format("step {}, {}: {}", step_count, batch_text(call.batch), fault));
    if (call.status != QUOIN_OK) {
      throw Error(Exit::numerical,
                  fmt::format("law '{}' of joint family '{}' refused a batch with status {} at step {}", law,
                              family.name, call.status, step_count));
    }
    // Failed points keep their old state, so asking again, this time with the status by point, names the same ones.
    ChunkJumps jump;
    contact_jumps(model, chunk, data, &jump);
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
      const Vec3& x = model.point_position[p];
      const Joint& joint = model.assembly.joints[static_cast<std::size_t>(model.point_joint[p])];
      throw Error(
          Exit::numerical,
          fmt::format("law '{}' failed at step {}, time {:.6g} s: joint {} (family '{}', blocks {} and {}), contact "
                      "point at ({:.4f}, {:.4f}, {:.4f}) m, opening {:.6g} m, slip in the step ({:.6g}, {:.6g}) m, "
                      "traction ({:.6g}, {:.6g}, {:.6g}) Pa. A smaller solver.time_step_fraction than {:g} may help",
                      law, step_count, now(), model.point_joint[p], family.name, joint.block_a, joint.block_b, x[0],
                      x[1], x[2], jump.normal[i], jump.slip_s[i], jump.slip_t[i], traction[0][p], traction[1][p],
                      traction[2][p], scene.solver.time_step_fraction));
    }
    throw Error(Exit::numerical,
                fmt::format("law '{}' says at step {} that {} points failed, and names none: {}; tell its author", law,
                            step_count, call.batch.failed_count, batch_text(call.batch)));
  }
  throw Error(Exit::numerical, fmt::format("a law failed at step {}", step_count));
}

std::string Simulation::Impl::batch_text(const quoin_batch& batch) const {
  for (std::size_t c = 0; c < calls.size(); ++c) {
    if (&calls[c].batch != &batch) continue;
    const ContactChunk& chunk = model.chunks[c];
    const Vec3& x = model.point_position[static_cast<std::size_t>(chunk.first_point)];
    return fmt::format("contact points {} to {} of joint family '{}', from ({:.3f}, {:.3f}, {:.3f}) m on",
                       chunk.first_point, chunk.first_point + chunk.point_count - 1,
                       model.families[static_cast<std::size_t>(chunk.family)].name, x[0], x[1], x[2]);
  }
  return large_motion ? large_motion->batch_text(batch) : fmt::format("a batch of {} points", batch.count);
}

}  // namespace quoin
