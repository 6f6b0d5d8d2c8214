#include "step/measure.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/error.h"
#include "base/larger.h"
#include "members/members.h"
#include "model/world_results.h"
#include "scene/weight_axis.h"
#include "step/actions/ground.h"
#include "step/block_motion.h"
#include "step/columns/columns.h"
#include "step/gather.h"
#include "step/large_motion_run.h"
#include "step/lattice_motion.h"
#include "step/monitor.h"
#include "step/rank_part.h"
#include "step/reactions.h"
#include "step/run_watch.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

// Inertia force of the monitor beside its direction, N.
double monitor_inertia(const Simulation::Impl& s, std::span<const std::uint8_t> held, std::size_t direction) {
  Vec3 sum{};
  for (const int block : s.monitor.blocks) {
    if (!is_rigid(s, block)) continue;
    const geometry::Vector net = net_force(s, block);
    for (std::size_t c = 0; c < 3; ++c)
      if (c != direction && (held[at(block)] >> c & 1) == 0) sum[c] += net[static_cast<int>(c)];
  }
  return norm_of(force_on_whole(s, sum));
}

// Displacement of the monitor, and the force along it, from the sum of the joint forces on it. A stage with a roof
// shows that, and the force that the walls carry to the monitor, their ground. The displacement is that at the time of
// the forces.
void measure_monitor(const Simulation::Impl& s, std::span<const std::uint8_t> held, std::size_t direction,
                     HistoryRow& row) {
  row.monitor_displacement = row.monitor_relative = displacement_at_forces(s, shown_blocks(s));
  row.monitor_relative -= row.ground_displacement;
  row.joint_force = force_on_whole(s, joint_force_on_monitor(s));
  row.displacement = row.monitor_displacement[direction] - s.monitor.start[direction];
  row.resistance = s.controls.floors.empty() ? -row.joint_force[direction] : row.joint_force[direction];
  const double upright = row.joint_force[at(upright_axis(s.scene))];
  row.vertical_force = s.monitor.stands_below ? -upright : upright;  // compression positive
  row.monitor_inertia = monitor_inertia(s, held, direction);
}

// Resultant of all forces on the blocks along an axis, N. It is their inertia force.
double dynamic_force(const Simulation::Impl& s, std::size_t direction) {
  const double whole = s.model.assembly.symmetry_factor;
  if (s.large_motion) {
    const double force = whole * s.large_motion->step_sums.net[static_cast<int>(direction)];
    const auto& members = s.large_motion->held_by.members;
    return members ? force + std::copysign(members->unbalanced_strips(), force) : force;
  }
  if (s.progress.stage < 0) return 0.0;
  double force = whole * s.model.total_mass() * s.data.gravity[direction];
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b) {
    const auto [index, lane] = s.lattice.place[b];
    const BodyLanes& lanes = s.lattice.bodies[static_cast<std::size_t>(index)];
    const double weight = s.model.bodies[b].mass * s.data.gravity[direction];
    force += whole * (lanes.prescribed[direction][lane] != 0.0
                          ? -joint_wrench(s, s.model.bodies[b].block).force[direction] - weight
                          : lanes.applied_force[direction][lane]);
  }
  for (const Drive& drive : s.actions.drives)
    if (s.model.place[at(drive.block)].body < 0) force += whole * drive.force_now[static_cast<int>(direction)];
  return force;
}

// Of a block that is no support, m.
double largest_displacement(const Simulation::Impl& s, std::span<const std::uint8_t> held) {
  const auto way_of = [&](int block) {
    if (s.large_motion) return moved(*s.large_motion, block);
    const auto& checked = s.small_motion.whole_motions;
    return geometry::vector((has_all(s) ? whole_motion_of(s, at(block)) : checked[at(block)]).translation);
  };
  double largest = 0.0;
  for (int i = 0; i < block_count(s); ++i)
    if (!is_fixed(s, i) || held[at(i)] != kAllPrescribed) largest = larger(largest, norm(way_of(i)));
  return largest;
}

}  // namespace

void sum_measurements(Simulation::Impl& s) {
  if (s.large_motion) return measure_large_motion_step(s);
  double unbalanced = 0.0, damping_before = 0.0, damping_after = 0.0, external_before = 0.0, external_after = 0.0;
  Energies now;
  for (const Measured& m : s.division.measured) {
    unbalanced = larger(unbalanced, m.unbalanced_squared);
    now.kinetic += m.kinetic;
    now.strain += m.strain;
    damping_before += m.damping_before;
    damping_after += m.damping_after;
    external_before += m.external_before;
    external_after += m.external_after;
  }
  double force_sum = 0.0, dissipated = 0.0, damped = 0.0;
  for (const ChunkSums& sums : s.contacts.sums) force_sum += sums.force_sum;
  for (const BoundCall& call : s.contacts.calls) {
    damped += call.damping;
    now.contact_stored += call.stored;
    for (std::size_t k = 0; k < 4; ++k) dissipated += call.dissipated[k], s.energy.dissipated[k] += call.dissipated[k];
  }
  s.energy.kinetic = now.kinetic;
  const double mean = s.model.point_count > 0 ? force_sum / s.model.point_count : 0.0;
  s.progress.unbalanced_ratio = unbalanced == 0.0 ? 0.0
                                : mean > 0.0      ? std::sqrt(unbalanced) / mean
                                                  : std::numeric_limits<double>::infinity();
  if (s.energy.sampled)
    check_energies(s, now, dissipated + damped, external_before - damping_before, external_after - damping_after);
  if (!s.energy.wanted) return;
  now.dissipated = s.energy.dissipated;
  s.energy.damping += damped;
  now.damping = s.energy.damping + damping_before;
  now.external = s.energy.external + external_before;
  now.detection = s.energy.lost_at_changes;
  s.energy.damping += damping_before + damping_after;
  s.energy.external += external_before + external_after;
  s.energy.now = now;
}

HistoryRow measure_row(const Simulation::Impl& s) {
  HistoryRow row;
  row.stage = std::max(s.progress.stage, 0);
  row.step = s.progress.step;
  row.time = time_now(s);
  row.unbalanced_ratio = s.progress.unbalanced_ratio;
  row.kinetic_energy = s.energy.kinetic;
  row.energies = s.energy.now;
  if (row.energies && !laws_give_energies(s)) {
    row.energies->contact_stored = row.energies->detection = std::numeric_limits<double>::quiet_NaN();
    row.energies->dissipated.fill(std::numeric_limits<double>::quiet_NaN());
  }
  const std::vector<JointWrench> supports = wrenches_of_supports(s);
  const std::vector<std::uint8_t> held = held_now(s);
  measure_reactions(s, supports, held, row);
  row.added = added_values(s);
  row.multiplier = s.actions.multiplier;
  const auto direction = s.scene.stages.empty() ? std::size_t{0} : at(s.scene.stages[at(row.stage)].direction);
  const bool acts = s.large_motion || std::ranges::any_of(s.scene.stages, [](const Stage& stage) {
                      return !beyond_lattice(stage).empty();
                    });
  if (s.scene.blocks || acts) row.largest_displacement = largest_displacement(s, held);
  if (acts) measure_base(s, supports, held, row);
  if (!s.monitor.blocks.empty()) measure_monitor(s, held, direction, row);
  row.dynamic_force = dynamic_force(s, direction);
  return row;
}

// Rows of a history are finite: NaN or infinity ends the run with a failure.
void require_finite(Simulation::Impl& s, const HistoryRow& row) {
  const std::pair<const char*, double> values[] = {
      {"kinetic energy", row.kinetic_energy},
      {"displacement of the monitor", row.displacement},
      {"force on the monitor", row.resistance},
      {"largest displacement", row.largest_displacement},
      {"energy balance", s.energy.now.value_or(Energies{}).balance_error()},
  };
  for (const auto& [name, value] : values) {
    if (std::isfinite(value)) continue;
    gather(s, Part::all, Who::first);
    if (const auto wrong = wrong_law(s); wrong && !wrong->finite)
      throw Error(Exit::numerical, fmt::format("stage '{}', step {}, time {:.6g} s: {}; tell its author",
                                               s.scene.stages[static_cast<std::size_t>(row.stage)].name, row.step,
                                               row.time, wrong->text));
    throw Error(Exit::numerical,
                fmt::format("stage '{}', step {}, time {:.6g} s: the {} is {}, no finite number; check the velocities "
                            "and forces of the stage, or reduce solver.time_step_fraction (the time step is {:.4g} s, "
                            "{:g} of 2/omega_max)",
                            s.scene.stages[static_cast<std::size_t>(row.stage)].name, row.step, row.time, name, value,
                            s.data.time_step, s.data.time_step / s.time_step.critical.value));
  }
}

}  // namespace quoin
