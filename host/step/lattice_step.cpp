#include "step/lattice_step.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "step/findings.h"
#include "step/lattice_motion.h"
#include "step/point_kernels.h"
#include "step/results.h"
#include "step/stages.h"

namespace quoin {

namespace {

void damp_chunk(Simulation::Impl& s, int index, ChunkJumps& jump) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  const auto first = static_cast<std::size_t>(chunk.first_point);
  blocks::PointColumns c{};
  for (std::size_t k = 0; k < 3; ++k) {
    c.traction[k] = s.lattice.traction[k].data() + first, c.old_traction[k] = jump.old_traction[k];
    c.viscous[k] = s.lattice.viscous[k].data() + first;
  }
  c.slip[0] = jump.slip_s, c.slip[1] = jump.slip_t;
  c.normal_jump = jump.normal, c.old_jump = s.lattice.old_jump.data() + first;
  c.area = s.model.area.data() + first;
  const auto count = static_cast<std::size_t>(chunk.point_count);
  double& taken = s.contacts.calls[static_cast<std::size_t>(index)].damping;
  if (s.time_step.impacts.viscosity.empty()) {
    taken = damp_points(c, count, s.time_step.joint_damping / s.data.time_step);
    return;
  }
  const auto [normal, along] = s.time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)];
  taken = damp_impacts(c, {}, count, {normal / s.data.time_step}, {along / s.data.time_step});
}

// Joints that act by the mean of the step (implicit_contacts.h).
void weigh_chunk(Simulation::Impl& s, int index, const ChunkJumps& jump, const double* normal_way) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  const ContactFamily& family = s.model.families[static_cast<std::size_t>(chunk.family)];
  const auto first = static_cast<std::size_t>(chunk.first_point);
  ImplicitContacts::Chunk c{};
  c.viscosity = s.time_step.impacts.viscosity[static_cast<std::size_t>(chunk.family)];
  for (std::size_t k = 0; k < 3; ++k) {
    c.traction[k] = s.lattice.traction[k].data() + first, c.old_traction[k] = jump.old_traction[k];
    if (c.viscosity[0] > 0.0) c.viscous[k] = s.lattice.viscous[k].data() + first;
  }
  c.way[0] = normal_way, c.way[1] = jump.slip_s, c.way[2] = jump.slip_t;
  c.area = s.model.area.data() + first;
  c.normal_stiffness = family.normal_stiffness, c.shear_stiffness = family.shear_stiffness;
  s.contacts.implicit.weigh(chunk, c, s.data.time_step);
  if (c.viscosity[0] == 0.0) std::copy_n(jump.normal, chunk.point_count, s.lattice.old_jump.data() + first);
}

// Sums of a chunk in a measured step.
void measure_chunk(Simulation::Impl& s, int index, const ChunkJumps& jump, bool report) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  ChunkSums& sums = s.contacts.sums[static_cast<std::size_t>(index)];
  sums.crushed_out = 0;
  sums.force_sum = sums.deepest = 0.0;
  for (int i = 0; i < chunk.point_count; ++i) {
    const auto p = static_cast<std::size_t>(chunk.first_point + i);
    if (report) sums.crushed_out += condition_of(s.lattice.flags[p]) == Condition::crushed_out;
    sums.force_sum += s.model.area[p] * norm_of(point_traction(s, p));
    if (jump.normal[i] < sums.deepest) sums.deepest = jump.normal[i], sums.deepest_point = chunk.first_point + i;
  }
}

}  // namespace

void advance_lattice_contacts(Simulation::Impl& s, int thread, int index, bool measure_step, bool report,
                              PhaseClock* clock) {
  ChunkJumps* const jump = s.division.jumps[static_cast<std::size_t>(thread)].get();
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  contact_jumps(s.model, chunk, s.data, jump);
  lap(clock, Phase::jumps);
  const auto& of_impacts = s.time_step.impacts.viscosity;
  const bool damped =
      s.lattice.damps_joints() && (of_impacts.empty() || of_impacts[static_cast<std::size_t>(chunk.family)][0] > 0.0);
  const bool implicit = s.contacts.implicit.in_use();
  for (std::size_t k = 0; (damped || implicit) && k < 3; ++k)
    std::copy_n(s.lattice.traction[k].data() + chunk.first_point, chunk.point_count, jump->old_traction[k]);
  evaluate_law(s, index, *jump, measure_step, report);
  lap(clock, Phase::law);
  alignas(64) double way[kChunk];  // motion normal to the joint, for damping in the next step
  for (int i = 0; implicit && i < chunk.point_count; ++i)
    way[i] = jump->normal[i] - s.lattice.old_jump[static_cast<std::size_t>(chunk.first_point + i)];
  if (damped) damp_chunk(s, index, *jump);
  if (measure_step) measure_chunk(s, index, *jump, report);
  if (implicit) weigh_chunk(s, index, *jump, way);
  const double* const of_damping[3] = {s.lattice.viscous[0].data(), s.lattice.viscous[1].data(),
                                       s.lattice.viscous[2].data()};
  contact_forces(s.model, chunk, s.data, damped ? of_damping : nullptr);
  lap(clock, Phase::contact_forces);
}

void evaluate_law(Simulation::Impl& s, int index, const ChunkJumps& jump, bool measure_step, bool report) {
  const ContactChunk& chunk = s.model.chunks[static_cast<std::size_t>(index)];
  const Material& material = *s.model.families[static_cast<std::size_t>(chunk.family)].material;
  BoundCall& call = s.contacts.calls[static_cast<std::size_t>(index)];
  call.bind_jumps(jump.normal, jump.slip_s, jump.slip_t);
  const std::uint64_t capabilities = material.api().capabilities;
  call.batch.flags = {report && (capabilities & QUOIN_CAN_FLAGS) ? s.lattice.flags.data() + chunk.first_point : nullptr,
                      1};
  const bool energies_too = s.energy.sampled && (capabilities & QUOIN_CAN_ENERGY);
  if (energies_too) s.contacts.bind_energies(call, chunk);
  if (call.evaluate(material)) s.contacts.law_failed.store(true, std::memory_order_relaxed);
  if (!measure_step) return;
  blocks::sum_energies(s.model.area.data() + chunk.first_point, call);
  if (energies_too) call.bind_energies(nullptr, {});
}

void advance_lattice_item(Simulation::Impl& s, int thread, int item, bool measure_step) {
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

// Completes the velocities of the gridpoints of prescribed bodies: a step writes only those across joints.
void settle_contacts(Simulation::Impl& s) {
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b) {
    const Vec3 moves = s.lattice.of_body(static_cast<int>(b), &BodyLanes::velocity);
    for (const std::int32_t slave : s.model.bodies[b].slave) {
      for (std::size_t c = 0; c < 3; ++c) s.lattice.velocity[static_cast<std::size_t>(slave) + c * kLanes] = moves[c];
    }
  }
  auto settle = [&](int, int piece) { s.contacts.implicit.settle(piece, s.data); };
  s.pool.for_each(s.contacts.implicit_end, settle);
}

void report_failed_points(Simulation::Impl& s) {
  for (std::size_t c = 0; c < s.contacts.calls.size(); ++c) {
    BoundCall& call = s.contacts.calls[c];
    if (!call.failed) continue;
    const ContactChunk& chunk = s.model.chunks[c];
    const ContactFamily& family = s.model.families[static_cast<std::size_t>(chunk.family)];
    ChunkJumps jump;  // those of the call are overwritten
    contact_jumps(s.model, chunk, s.data, &jump);
    call.bind_jumps(jump.normal, jump.slip_s, jump.slip_t);
    const auto point = [&](std::size_t i) {
      const std::size_t p = static_cast<std::size_t>(chunk.first_point) + i;
      const Vec3& x = s.model.point_position[p];
      const int index = s.model.point_joint[p];
      const Joint& joint = s.model.assembly.joints[static_cast<std::size_t>(index)];
      return fmt::format("joint {}, blocks {} and {}, contact point at ({:.4f}, {:.4f}, {:.4f}) m", index,
                         joint.block_a, joint.block_b, x[0], x[1], x[2]);
    };
    report_failed_call(*family.material, call,
                       {s.progress.step, time_now(s), solver_in_use(s).time_step_fraction, family.name,
                        batch_text(s, call.batch), point});
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
