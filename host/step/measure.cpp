// What a run reports of its step: a row of the history, energies, how far blocks have moved.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "step/columns/columns.h"
#include "step/monitor_side.h"
#include "step/state.h"

namespace quoin {

void Simulation::Impl::sum_measurements() {
  if (large_motion) return measure_large_motion_step();
  double unbalanced = 0.0, damping_before = 0.0, damping_after = 0.0, external_before = 0.0, external_after = 0.0;
  Energies now;
  for (const Measured& m : measured) {
    unbalanced = std::max(unbalanced, m.unbalanced_squared);
    if (std::isnan(m.unbalanced_squared)) unbalanced = m.unbalanced_squared;
    now.kinetic += m.kinetic;
    now.strain += m.strain;
    damping_before += m.damping_before;
    damping_after += m.damping_after;
    external_before += m.external_before;
    external_after += m.external_after;
  }
  double force_sum = 0.0, dissipated = 0.0, damped = 0.0;
  for (const LawCall& call : calls) {
    force_sum += call.force_sum;
    damped += call.damping;
    now.contact_stored += call.stored;
    for (std::size_t k = 0; k < 4; ++k) dissipated += call.dissipated[k], energy_dissipated[k] += call.dissipated[k];
  }
  kinetic = now.kinetic;
  const double mean = model.point_count > 0 ? force_sum / model.point_count : 0.0;
  unbalanced_ratio = unbalanced == 0.0 ? 0.0
                     : mean > 0.0      ? std::sqrt(unbalanced) / mean
                                       : std::numeric_limits<double>::infinity();
  if (sample_energy)
    check_energies(now, dissipated + damped, external_before - damping_before, external_after - damping_after);
  if (!want_energy) return;
  now.dissipated = energy_dissipated;
  energy_damping += damped;
  now.damping = energy_damping + damping_before;
  now.external = energy_external + external_before;
  now.detection = energy_inertia;
  energy_damping += damping_before + damping_after;
  energy_external += external_before + external_after;
  energies = now;
}

HistoryRow Simulation::Impl::measure() const {
  HistoryRow row;
  row.stage = std::max(stage, 0);
  row.step = step_count;
  row.time = now();
  row.unbalanced_ratio = unbalanced_ratio;
  row.kinetic_energy = kinetic;
  row.energies = energies;
  measure_reactions(row);
  row.added = added_values(*this);
  if (large_motion) {
    measure_large_motion(row);
    return row;
  }
  const bool acts =
      std::any_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) { return !s.beyond_lattice().empty(); });
  if (scene.blocks || acts) row.largest_displacement = largest_displacement();
  if (acts) measure_base(row);
  if (!monitor.empty() || !monitor_loaded.empty()) measure_monitor(row);
  return row;
}

void Simulation::Impl::measure_monitor(HistoryRow& row) const {
  // Forces are those of the last evaluation of the laws, so the displacement is given for that time too.
  const Vec3 moved = mean_of(monitor, &BodyLanes::displacement), velocity_now = mean_of(monitor, &BodyLanes::velocity);
  MonitorSide side;
  for (const int b : monitor) {
    const Vec3 joints = joint_force(b);
    for (std::size_t c = 0; c < 3; ++c) row.joint_force[c] += model.assembly.symmetry_factor * joints[c];
    const RigidBody& body = model.bodies[static_cast<std::size_t>(b)];
    const Brick& brick = model.assembly.bricks[static_cast<std::size_t>(body.block)];
    const double middle = brick.origin[1] + 0.5 * brick.size[1];
    for (const Vec3& arm : body.arm) side.add(body.centre[1] + arm[1] - middle);
  }
  const auto direction = static_cast<std::size_t>(scene.stages[static_cast<std::size_t>(stage)].direction);
  for (std::size_t c = 0; c < 3; ++c) row.monitor_displacement[c] = moved[c] - data.time_step * velocity_now[c];
  for (const int i : monitor_loaded) {
    const Vec3 of_block = displacement_of_loaded(i);
    const Brick& brick =
        model.assembly.bricks[static_cast<std::size_t>(loaded_blocks[static_cast<std::size_t>(i)].block)];
    for (std::size_t c = 0; c < 3; ++c)
      row.monitor_displacement[c] += of_block[c] / static_cast<double>(monitor_loaded.size());
    for (const MonitorPoint& at : monitor_points)
      side.add(model.point_position[static_cast<std::size_t>(at.point)][1] - brick.origin[1] - 0.5 * brick.size[1]);
  }
  for (std::size_t chunk = 0; chunk < calls.size() && !monitor_loaded.empty(); ++chunk) {
    const Vec3 joints = has_all() ? sum_on_monitor(static_cast<int>(chunk)) : calls[chunk].on_monitor;
    for (std::size_t c = 0; c < 3; ++c) row.joint_force[c] += model.assembly.symmetry_factor * joints[c];
  }
  for (std::size_t c = 0; c < 3; ++c)
    row.monitor_relative[c] = row.monitor_displacement[c] - row.ground_displacement[c];
  row.displacement = row.monitor_displacement[direction] - monitor_start[direction];
  row.resistance = -row.joint_force[direction];
  if (!whiffletree.empty()) {
    // The roof against the shear force that the walls carry to the ground.
    row.monitor_displacement = {floor_displacement(whiffletree.size() - 1), 0.0, 0.0};
    row.displacement = row.monitor_displacement[0] - monitor_start[0];
    row.resistance = row.joint_force[0];
  }
  const double whole = model.assembly.symmetry_factor;
  row.dynamic_force = whole * model.total_mass() * data.gravity[direction];
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const auto [index, lane] = body_place[b];
    const BodyLanes& lanes = body_lanes[static_cast<std::size_t>(index)];
    const double weight = model.bodies[b].mass * data.gravity[direction];
    row.dynamic_force +=
        whole * (lanes.prescribed[direction][lane] != 0.0 ? -joint_force(static_cast<int>(b))[direction] - weight
                                                          : lanes.applied_force[direction][lane]);
  }
  for (const LoadRamp& ramp : load_ramps) row.dynamic_force += whole * ramp.now[direction];
  row.vertical_force = side.joints_are_above() ? -row.joint_force[1] : row.joint_force[1];  // compression positive
}

Vec3 Simulation::Impl::displacement_of_loaded(int index) const {
  const LoadedBlock& block = loaded_blocks[static_cast<std::size_t>(index)];
  Vec3 mean{};
  model.for_each_gridpoint(block.block, [&](std::size_t offset, double mass) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t k = offset + c * kLanes;
      mean[c] += mass / block.mass * (displacement[k] - data.time_step * velocity[k]);
    }
  });
  return mean;
}

Vec3 Simulation::Impl::point_traction(std::size_t point) const {
  Vec3 sum;
  for (std::size_t k = 0; k < 3; ++k) sum[k] = traction[k][point] + (damps_impacts() ? viscous[k][point] : 0.0);
  return sum;
}

Vec3 Simulation::Impl::sum_on_monitor(int index) const {
  const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(index)];
  const auto n = static_cast<std::size_t>(chunk.axis);
  Vec3 sum{};
  const auto first = std::lower_bound(monitor_points.begin(), monitor_points.end(), chunk.first_point,
                                      [](const MonitorPoint& m, std::int32_t point) { return m.point < point; });
  for (auto m = first; m != monitor_points.end() && m->point < chunk.first_point + chunk.point_count; ++m) {
    const auto p = static_cast<std::size_t>(m->point);
    const Vec3 of_point = point_traction(p);
    for (std::size_t c = 0; c < 3; ++c) sum[(n + c) % 3] += m->sign * (model.area[p] * of_point[c]);
  }
  return sum;
}

// Rows of a history are finite: NaN or infinity ends the run as failed.
void Simulation::Impl::require_finite(const HistoryRow& row) {
  const std::pair<const char*, double> values[] = {
      {"kinetic energy", row.kinetic_energy},
      {"displacement of the monitor", row.displacement},
      {"force on the monitor", row.resistance},
      {"largest displacement", row.largest_displacement},
      {"energy balance", row.energies.value_or(Energies{}).balance_error()},
  };
  for (const auto& [name, value] : values) {
    if (std::isfinite(value)) continue;
    gather(Part::all, Who::first);
    if (const auto wrong = wrong_law(); wrong && !wrong->finite)
      throw Error(Exit::numerical,
                  fmt::format("stage '{}', step {}, time {:.6g} s: {}; tell its author",
                              scene.stages[static_cast<std::size_t>(row.stage)].name, row.step, row.time, wrong->text));
    throw Error(Exit::numerical,
                fmt::format("stage '{}', step {}, time {:.6g} s: the {} is {}, no finite number; check the velocities "
                            "and forces of the stage, or reduce solver.time_step_fraction (the time step is {:.4g} s, "
                            "{:g} of 2/omega_max)",
                            scene.stages[static_cast<std::size_t>(row.stage)].name, row.step, row.time, name, value,
                            data.time_step, data.time_step / time_step.critical.value));
  }
}

Vec3 Simulation::Impl::of_body(int body, BodyLanes::Quantity BodyLanes::*quantity) const {
  const auto [index, lane] = body_place[static_cast<std::size_t>(body)];
  const BodyLanes::Quantity& value = body_lanes[static_cast<std::size_t>(index)].*quantity;
  return {value[0][lane], value[1][lane], value[2][lane]};
}

Vec3 Simulation::Impl::of_body_at(int body, BodyLanes::Quantity BodyLanes::*translation,
                                  BodyLanes::Quantity BodyLanes::*rotation, const Vec3& position) const {
  const Vec3 turned = of_body(body, rotation);
  const Vec3& centre = model.bodies[static_cast<std::size_t>(body)].centre;
  Vec3 result = of_body(body, translation);
  for (std::size_t c = 0; c < 3; ++c) {
    const std::size_t next = (c + 1) % 3, last = (c + 2) % 3;
    result[c] =
        result[c] + turned[next] * (position[last] - centre[last]) - turned[last] * (position[next] - centre[next]);
  }
  return result;
}

Vec3 Simulation::Impl::joint_force(int body) const {
  return has_all() ? sum_joint_force(body) : body_wrench[static_cast<std::size_t>(body)].force;
}

Vec3 Simulation::Impl::sum_joint_force(int body) const {
  const RigidBody& b = model.bodies[static_cast<std::size_t>(body)];
  Vec3 sum{};
  for (std::size_t i = 0; i < b.point.size(); ++i) {
    const auto p = static_cast<std::size_t>(b.point[i]), n = static_cast<std::size_t>(model.point_axis[p]);
    const Vec3 of_point = point_traction(p);
    for (std::size_t c = 0; c < 3; ++c) sum[(n + c) % 3] += b.sign[i] * (model.area[p] * of_point[c]);
  }
  return sum;
}

Vec3 Simulation::Impl::jump_at_traction(std::int32_t point) const { return jump_of(point, 1.0, -data.time_step); }

std::pair<Vec3, Vec3> Simulation::Impl::motion_of_sides(std::int32_t point, double of_displacement,
                                                        double of_velocity) const {
  const auto p = static_cast<std::size_t>(point);
  const auto motion_of = [&](int block, std::int32_t gridpoint) {
    const int body = model.place[static_cast<std::size_t>(block)].body;
    Vec3 u, v;
    if (body < 0) {
      const auto i = static_cast<std::size_t>(gridpoint);
      u = {displacement[i], displacement[i + kLanes], displacement[i + 2 * kLanes]};
      v = {velocity[i], velocity[i + kLanes], velocity[i + 2 * kLanes]};
    } else {
      u = of_body_at(body, &BodyLanes::displacement, &BodyLanes::rotation, model.point_position[p]);
      v = of_body_at(body, &BodyLanes::velocity, &BodyLanes::spin, model.point_position[p]);
    }
    for (std::size_t c = 0; c < 3; ++c) u[c] = of_displacement * u[c] + of_velocity * v[c];
    return u;
  };
  const Model::Sides sides = model.sides_of(point);
  return {motion_of(sides.a, model.node_a[p]), motion_of(sides.b, model.node_b[p])};
}

Vec3 Simulation::Impl::jump_of(std::int32_t point, double of_displacement, double of_velocity) const {
  const auto [a, b] = motion_of_sides(point, of_displacement, of_velocity);
  const std::size_t n = model.point_axis[static_cast<std::size_t>(point)], s = (n + 1) % 3, t = (n + 2) % 3;
  return {b[n] - a[n], b[s] - a[s], b[t] - a[t]};
}

double Simulation::Impl::opening_at_traction(std::int32_t point) const {
  return jump_at_traction(point)[0] + (normal_shift.empty() ? 0.0 : normal_shift[static_cast<std::size_t>(point)]);
}

Vec3 Simulation::Impl::mean_of(const std::vector<int>& indices, BodyLanes::Quantity BodyLanes::*quantity) const {
  Vec3 mean{};
  for (const int b : indices) {
    const Vec3 value = of_body(b, quantity);
    for (std::size_t c = 0; c < 3; ++c) mean[c] += value[c] / static_cast<double>(indices.size());
  }
  return mean;
}

}  // namespace quoin
