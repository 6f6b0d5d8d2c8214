#include "step/simulation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "blocks/motion.h"
#include "step/law_swap.h"
#include "step/state.h"

namespace quoin {
namespace {

using Clock = std::chrono::steady_clock;

constexpr long kCheckInterval = 20;       // steps between two looks at the unbalanced force
constexpr long kCollapseInterval = 10;    // steps between two looks at how far blocks have moved
constexpr int kCalmChecks = 5;            // looks in a row that must pass: one may catch a swing at its turning point
constexpr long kDefaultRows = 1000;       // rows of a stage with record_interval 0
constexpr long kHalfCycleRows = 200;      // rows of a half cycle with record_interval 0
constexpr long kUnknownLength = 200;      // steps between rows of a stage whose length cannot be foreseen
constexpr long kPauseInterval = 16;       // steps between two moments at which a checkpoint may be taken
constexpr double kProgressPeriod = 0.25;  // s

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

}  // namespace

// ---- The step ------------------------------------------------------------------------------------------------------

// One step of central differences. Displacements are those of the time t; velocities those of t - dt/2, then t + dt/2.
// Both phases go over independent pieces, so the bits do not depend on which thread does which.
void Simulation::Impl::step_once(bool measure_step, bool report) {
  apply_controls();
  if (riding) riding->begin_step();
  const auto start = timing ? Clock::now() : Clock::time_point();

  auto contacts = [&](int thread, int i) {
    if (riding) return riding->advance_contacts(i);
    ChunkJumps* const jump = jumps[static_cast<std::size_t>(thread)].get();
    const ContactChunk& chunk = model.chunks[static_cast<std::size_t>(i)];
    contact_jumps(model, chunk, data, jump);
    evaluate_law(i, *jump, measure_step, report);
    contact_forces(model, chunk, data);
  };
  pool.for_each(chunk_end, contacts);
  if (law_failed.load(std::memory_order_relaxed)) report_failed_points();
  const auto middle = timing ? Clock::now() : Clock::time_point();

  auto blocks_and_bodies = [&](int thread, int i) {
    if (riding) return riding->advance_block(i);
    double* const memory = scratch[static_cast<std::size_t>(thread)].data();
    advance_item(i, memory, measure_step ? &measured[static_cast<std::size_t>(i)] : nullptr);
  };
  pool.for_each(item_end, blocks_and_bodies);
  if (riding) end_riding_step();
  if (measure_step) sum_measurements();
  if (report) flags_step = step_count;
  ++step_count;
  ++stage_step;

  if (timing) {
    times.contacts += std::chrono::duration<double>(middle - start).count();
    times.blocks += seconds_since(middle);
    ++times.steps;
  }
}

void Simulation::Impl::advance_item(int item, double* memory, Measured* record) {
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
  const quoin_status status = family.material->api().evaluate(family.material->handle(), &batch);
  if (status != QUOIN_OK || batch.failed_count != 0) {
    call.failed = true;
    call.status = status;
    law_failed.store(true, std::memory_order_relaxed);
  }
  if (!measure_step) return;

  call.force_sum = call.stored = 0.0;
  call.dissipated = {};
  for (int i = chunk.first_point; i < chunk.first_point + chunk.point_count; ++i) {
    const auto p = static_cast<std::size_t>(i);
    call.force_sum += model.area[p] * std::sqrt(traction[0][p] * traction[0][p] + traction[1][p] * traction[1][p] +
                                                traction[2][p] * traction[2][p]);
    if (!batch.energy_stored.data) continue;
    call.stored += model.area[p] * energy_columns[0][p];
    for (std::size_t k = 0; k < 4; ++k) call.dissipated[k] += model.area[p] * energy_columns[k + 1][p];
  }
}

void Simulation::Impl::report_failed_points() {
  for (std::size_t c = 0; c < calls.size(); ++c) {
    LawCall& call = calls[c];
    if (!call.failed) continue;
    const ContactChunk& chunk = model.chunks[c];
    const ContactFamily& family = model.families[static_cast<std::size_t>(chunk.family)];
    const std::string law = family.material->api().id;
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
    family.material->api().evaluate(family.material->handle(), &call.batch);
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
                      law, step_count, static_cast<double>(step_count) * data.time_step, model.point_joint[p],
                      family.name, joint.block_a, joint.block_b, x[0], x[1], x[2], jump.normal[i], jump.slip_s[i],
                      jump.slip_t[i], traction[0][p], traction[1][p], traction[2][p], scene.solver.time_step_fraction));
    }
  }
  throw Error(Exit::numerical, fmt::format("a law failed at step {}", step_count));
}

// ---- Controls and measurements -------------------------------------------------------------------------------------

void Simulation::Impl::apply_controls() {
  if (!controls_settled)
    follow_ramps();
  else if (riding && scene.stages[static_cast<std::size_t>(stage)].collapse)
    drive_blocks(1.0);  // its body force goes on growing; all else stays as the end of the ramp has left it
  else if (!rest_known)
    find_bodies_at_rest();
  if (!whiffletree.empty()) pull_whiffletree();
}

double Simulation::Impl::mean_along_x(const LoadedBlock& block, const LaneVector<double>& field) const {
  double sum = 0.0;
  model.for_each_gridpoint(block.block, [&](std::size_t offset, double mass) { sum += mass * field[offset]; });
  return sum / block.mass;
}

double Simulation::Impl::floor_displacement_now(std::size_t floor) const {
  const Floor& f = whiffletree[floor];
  if (riding) return riding_displacement(f.riding)[0];
  double sum = static_cast<double>(f.bodies.size()) * mean_of(f.bodies, &BodyLanes::displacement)[0];
  for (const int i : f.loaded) sum += mean_along_x(loaded_blocks[static_cast<std::size_t>(i)], displacement);
  return sum / f.count();
}

double Simulation::Impl::floor_displacement(std::size_t floor) const {
  const Floor& f = whiffletree[floor];
  if (riding) {
    double rate = 0.0;
    for (const int block : f.riding) rate += riding->velocity(block).x / f.count();
    return floor_displacement_now(floor) - data.time_step * rate;
  }
  double rate = static_cast<double>(f.bodies.size()) * mean_of(f.bodies, &BodyLanes::velocity)[0];
  for (const int i : f.loaded) rate += mean_along_x(loaded_blocks[static_cast<std::size_t>(i)], velocity);
  return floor_displacement_now(floor) - data.time_step * rate / f.count();
}

void Simulation::Impl::apply_load(std::size_t loaded) {
  const LoadedBlock& block = loaded_blocks[loaded];
  const Model::BlockPlace& where = model.place[static_cast<std::size_t>(block.block)];
  const auto first = static_cast<std::size_t>(load_of_group[static_cast<std::size_t>(where.group)] - load.data());
  for (std::size_t c = 0; c < 3; ++c)
    load[first + c * kLanes + static_cast<std::size_t>(where.lane)] = load_ramps[loaded].now[c] / block.mass;
}

void Simulation::Impl::pull_whiffletree() {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  const Whiffletree& tree = *settings.whiffletree;
  const double moved =
      cycles ? cycles->position(stage_time()) : tree.velocity * smooth_way(stage_time(), settings.ramp_time);
  // Displacements of now, as the joints have them: a spring that sees them one step late feeds energy in at any step.
  double mean = 0.0;
  for (std::size_t f = 0; f < whiffletree.size(); ++f)
    mean += floor_displacement_now(f) / static_cast<double>(whiffletree.size());
  const double pull = tree.stiffness * (monitor_start[0] + moved - mean);
  for (const Floor& floor : whiffletree) {
    for (const int block : floor.riding) pull_block(block, pull / floor.count());
    for (const int body : floor.bodies) {
      const auto [lanes, lane] = body_place[static_cast<std::size_t>(body)];
      body_lanes[static_cast<std::size_t>(lanes)].applied_force[0][lane] = pull / floor.count();
    }
    for (const int i : floor.loaded) {
      load_ramps[static_cast<std::size_t>(i)].now[0] = pull / floor.count();
      apply_load(static_cast<std::size_t>(i));
    }
  }
}

void Simulation::Impl::follow_ramps() {
  const double ramp = stage >= 0 ? scene.stages[static_cast<std::size_t>(stage)].ramp_time : 0.0;
  const double elapsed =
      riding ? stage_time() + 0.5 * riding->time_step() : (static_cast<double>(stage_step) + 0.5) * data.time_step;
  const double s = ramp > 0.0 ? smooth_step(elapsed / ramp) : 1.0;
  const auto between = [s](double from, double to) { return s >= 1.0 ? to : from + s * (to - from); };
  for (const int body : ramped_bodies) {
    const auto b = static_cast<std::size_t>(body);
    const auto [index, lane] = body_place[b];
    BodyLanes& lanes = body_lanes[static_cast<std::size_t>(index)];
    for (std::size_t c = 0; c < 3; ++c) {
      lanes.prescribed_velocity[c][lane] = ramps[b].in_cycles[c] != 0.0
                                               ? velocity_in_cycles(ramps[b].velocity_from[c])
                                               : between(ramps[b].velocity_from[c], ramps[b].velocity_to[c]);
      lanes.applied_force[c][lane] = between(ramps[b].force_from[c], ramps[b].force_to[c]);
    }
  }
  for (std::size_t i = 0; i < loaded_blocks.size(); ++i) {
    LoadRamp& of_block = load_ramps[i];
    for (std::size_t c = 0; c < 3; ++c) of_block.now[c] = between(of_block.from[c], of_block.to[c]);
    apply_load(i);
  }
  for (std::size_t c = 0; c < 3; ++c) data.gravity[c] = between(gravity_from[c], gravity_to[c]);
  controls_settled = s >= 1.0 && !(cycles && whiffletree.empty());
  if (riding) drive_blocks(s);
}

double Simulation::Impl::velocity_in_cycles(double initial_velocity) const {
  const double dt = data.time_step, t = stage_time();
  return (cycles->position(t + dt, initial_velocity) - cycles->position(t, initial_velocity)) / dt;
}

bool Simulation::Impl::force_lost() {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  if (!settings.cycles || !settings.cycles->stop_at_force_loss || stage_step % kCheckInterval != 0) return false;
  const int half_cycle = cycles->half_cycle(stage_time());
  if (!force_loss.see(measure().resistance, half_cycle, cycles->target(half_cycle),
                      *settings.cycles->stop_at_force_loss))
    return false;
  outcome.force_losses.push_back({stage, force_loss.half_cycle(), force_loss.force(), force_loss.largest()});
  return true;
}

void Simulation::Impl::sum_measurements() {
  if (riding) return measure_riding_step();
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
  double force_sum = 0.0;
  for (const LawCall& call : calls) {
    force_sum += call.force_sum;
    now.contact_stored += call.stored;
    for (std::size_t k = 0; k < 4; ++k) energy_dissipated[k] += call.dissipated[k];
  }
  kinetic = now.kinetic;
  const double mean = model.point_count > 0 ? force_sum / model.point_count : 0.0;
  unbalanced_ratio = unbalanced == 0.0 ? 0.0
                     : mean > 0.0      ? std::sqrt(unbalanced) / mean
                                       : std::numeric_limits<double>::infinity();
  if (!want_energy) return;
  now.dissipated = energy_dissipated;
  now.damping = energy_damping + damping_before;
  now.external = energy_external + external_before;
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
  if (riding) {
    measure_riding(row);
    return row;
  }
  if (scene.blocks) row.largest_displacement = largest_displacement();
  if (monitor.empty()) return row;

  // Forces are those of the last evaluation of the laws, so the displacement is given for that time too.
  const Vec3 moved = mean_of(monitor, &BodyLanes::displacement), velocity_now = mean_of(monitor, &BodyLanes::velocity);
  double arms = 0.0;
  for (const int b : monitor) {
    const Vec3 joints = joint_force(b);
    for (std::size_t c = 0; c < 3; ++c) row.joint_force[c] += model.assembly.symmetry_factor * joints[c];
    for (const Vec3& arm : model.bodies[static_cast<std::size_t>(b)].arm) arms += arm[1];
  }
  const auto direction = static_cast<std::size_t>(scene.stages[static_cast<std::size_t>(stage)].direction);
  for (std::size_t c = 0; c < 3; ++c) row.monitor_displacement[c] = moved[c] - data.time_step * velocity_now[c];
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
  row.vertical_force = arms <= 0.0 ? row.joint_force[1] : -row.joint_force[1];  // joints below push the body up
  return row;
}

// Lattice blocks by their corner gridpoints, rigid bodies by their own rotation.
WholeMotion Simulation::Impl::whole_motion_of(std::size_t brick) const {
  const Model::BlockPlace& where = model.place[brick];
  if (where.body >= 0)
    return {of_body(where.body, &BodyLanes::displacement), of_body(where.body, &BodyLanes::rotation)};
  const BlockGroup& group = model.groups[static_cast<std::size_t>(where.group)];
  const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
  std::array<Vec3, 8> corner;
  for (int k = 0; k < 8; ++k) {
    const int node =
        shape.node_index(k & 1 ? shape.zones[0] : 0, k & 2 ? shape.zones[1] : 0, k & 4 ? shape.zones[2] : 0);
    const double* u = displacement.data() + static_cast<std::size_t>(group.first_line + node) * kLine + where.lane;
    corner[static_cast<std::size_t>(k)] = {u[0], u[kLanes], u[2 * kLanes]};
  }
  return whole_motion(shape.size, corner);
}

void Simulation::Impl::look_at_motion() {
  if (riding) return look_at_riding_motion();
  whole_motions.resize(model.assembly.bricks.size());
  for (std::size_t i = 0; i < whole_motions.size(); ++i) whole_motions[i] = whole_motion_of(i);
  joint_sliding.look(whole_motions, &motion_seen);
}

std::string Simulation::Impl::past_motion_bound() const {
  if (!riding) return past_bound(motion_seen, scene.solver.motion_bound, model.assembly);
  // Blocks of any shape leave small displacements by themselves.
  if (scene.solver.large_motion != LargeMotion::never || riding->small_displacement()) return "";
  return "blocks have moved further than small displacements allow (contact.small_displacement)";
}

// What a history may hold: a run whose rows are no numbers has failed, whatever comes after.
void Simulation::Impl::require_finite(const HistoryRow& row) const {
  const std::pair<const char*, double> values[] = {
      {"kinetic energy", row.kinetic_energy},
      {"displacement of the monitor", row.displacement},
      {"force on the monitor", row.resistance},
      {"largest displacement", row.largest_displacement},
      {"energy balance", row.energies.value_or(Energies{}).balance_error()},
  };
  for (const auto& [name, value] : values) {
    if (std::isfinite(value)) continue;
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
  const RigidBody& b = model.bodies[static_cast<std::size_t>(body)];
  Vec3 sum{};
  for (std::size_t i = 0; i < b.point.size(); ++i) {
    const auto p = static_cast<std::size_t>(b.point[i]), n = static_cast<std::size_t>(model.point_axis[p]);
    for (std::size_t c = 0; c < 3; ++c) sum[(n + c) % 3] += b.sign[i] * (model.area[p] * traction[c][p]);
  }
  return sum;
}

Vec3 Simulation::Impl::jump_at_traction(std::int32_t point) const { return jump_of(point, 1.0, -data.time_step); }

Vec3 Simulation::Impl::jump_of(std::int32_t point, double of_displacement, double of_velocity) const {
  const auto p = static_cast<std::size_t>(point);
  const Joint& joint = model.assembly.joints[static_cast<std::size_t>(model.point_joint[p])];
  const auto displacement_of = [&](int block, std::int32_t gridpoint) {
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
  const bool in_order = joint.face_a % 2 == 1;  // normals point along +axis
  const Vec3 a = displacement_of(in_order ? joint.block_a : joint.block_b, model.node_a[p]);
  const Vec3 b = displacement_of(in_order ? joint.block_b : joint.block_a, model.node_b[p]);
  const std::size_t n = model.point_axis[p], s = (n + 1) % 3, t = (n + 2) % 3;
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

// ---- Stages --------------------------------------------------------------------------------------------------------

void Simulation::Impl::begin_stage(int index) {
  const Stage& settings = scene.stages[static_cast<std::size_t>(index)];
  if (riding)
    begin_riding_stage(settings, index > 0 ? &scene.stages[static_cast<std::size_t>(index) - 1] : nullptr);
  else
    control_bodies(settings);
  gravity_from = data.gravity;
  gravity_to = settings.gravity;
  controls_settled = false;
  stage = index;
  stage_step = 0;
  in_stage = true;
  bind_controls();
  bind_whiffletree();
  choose_damping();
  if (!whiffletree.empty()) {
    // The tree starts without force: from the mean displacement of the floors.
    monitor_start = {};
    for (std::size_t f = 0; f < whiffletree.size(); ++f)
      monitor_start[0] += floor_displacement(f) / static_cast<double>(whiffletree.size());
  }
  calm_checks = 0;
  next_frame = 0;
  next_row = 0;
  force_loss = {};
  swaps.clear();
  row_interval = chosen_record_interval();
  for (const auto& [family, law] : settings.law_swaps) swap_law(family, law);
}

void Simulation::Impl::control_bodies(const Stage& settings) {
  for (const BodyControl& control : settings.controls) {
    const bool deformable = !model.deformable_blocks_named(control.body).empty();
    if (model.bodies_named(control.body).empty() && !deformable) {
      throw Error(Exit::bad_input,
                  fmt::format("{}: stage '{}' controls the body '{}', but the assembly has no block of "
                              "that name",
                              settings.source.text, settings.name, control.body));
    }
    if (deformable && control.kind != std::array{DofKind::free, DofKind::free, DofKind::free}) {
      throw Error(Exit::bad_input,
                  fmt::format("{}: stage '{}' holds or moves '{}', a deformable block: it can only be loaded; make all "
                              "of its velocity \"free\"",
                              settings.source.text, settings.name, control.body));
    }
  }
  const std::vector<int> new_monitor = model.bodies_named(settings.monitor);
  if (!settings.monitor.empty() && new_monitor.empty()) {
    throw Error(Exit::bad_input,
                fmt::format("{}: stage '{}' monitors the body '{}', but the assembly has no rigid block of that "
                            "name",
                            settings.source.text, settings.name, settings.monitor));
  }
  if (settings.displacement && new_monitor.empty()) {
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}' ends by displacement but has no monitor body",
                                             settings.source.text, settings.name));
  }

  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const auto [place, lane] = body_place[b];
    BodyLanes& body = body_lanes[static_cast<std::size_t>(place)];
    const Vec3 joints = joint_force(static_cast<int>(b));
    const auto control = std::find_if(settings.controls.begin(), settings.controls.end(), [&](const BodyControl& c) {
      return !c.body.empty() && c.body == model.bodies[b].name;
    });
    const bool controlled = control != settings.controls.end();
    for (std::size_t c = 0; c < 3; ++c) {
      const bool was_prescribed = body.prescribed[c][lane] != 0.0;
      const bool prescribed = controlled && control->kind[c] == DofKind::velocity;
      // What a support has carried so far is the force from which a newly freed component starts.
      const double carried =
          was_prescribed ? -joints[c] - model.bodies[b].mass * data.gravity[c] : body.applied_force[c][lane];
      ramps[b].velocity_from[c] = was_prescribed ? body.prescribed_velocity[c][lane] : body.velocity[c][lane];
      ramps[b].velocity_to[c] = prescribed ? control->velocity[c] : 0.0;
      ramps[b].force_from[c] = prescribed ? 0.0 : carried;
      ramps[b].force_to[c] = controlled && !prescribed ? control->force[c] : 0.0;
      ramps[b].in_cycles[c] = controlled && control->in_cycles == static_cast<int>(c) ? 1.0 : 0.0;
      const bool was_held = body.prescribed[c + 3][lane] != 0.0, held = controlled && !control->may_turn;
      // The motion of what is driven is no kinetic energy: what is let go brings its own, what is caught leaves it to
      // the support.
      const double linear = 0.5 * model.bodies[b].mass * body.velocity[c][lane] * body.velocity[c][lane];
      const double angular = 0.5 * model.bodies[b].inertia[c] * body.spin[c][lane] * body.spin[c][lane];
      energy_external += (was_prescribed - prescribed) * linear + (was_held - held) * angular;
      body.prescribed[c][lane] = prescribed ? 1.0 : 0.0;
      body.prescribed[c + 3][lane] = held ? 1.0 : 0.0;
    }
  }
  for (std::size_t i = 0; i < loaded_blocks.size(); ++i) {
    const std::string& name = model.assembly.bricks[static_cast<std::size_t>(loaded_blocks[i].block)].body;
    const auto control = std::find_if(settings.controls.begin(), settings.controls.end(),
                                      [&](const BodyControl& c) { return c.body == name; });
    load_ramps[i].from = load_ramps[i].now;
    load_ramps[i].to = control != settings.controls.end() ? control->force : Vec3{};
  }
  monitor = new_monitor;
  monitor_start = mean_of(monitor, &BodyLanes::displacement);
}

void Simulation::Impl::bind_controls() {
  cycles.reset();
  if (stage >= 0 && scene.stages[static_cast<std::size_t>(stage)].cycles)
    cycles.emplace(*scene.stages[static_cast<std::size_t>(stage)].cycles);
  ramped_bodies.clear();
  for (BodyLanes& lanes : body_lanes) lanes.any_prescribed = false;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const auto [index, lane] = body_place[b];
    BodyLanes& lanes = body_lanes[static_cast<std::size_t>(index)];
    for (const auto& prescribed : lanes.prescribed)
      lanes.any_prescribed = lanes.any_prescribed || prescribed[lane] != 0.0;
    const BodyRamp& ramp = ramps[b];
    if (ramp.velocity_from != ramp.velocity_to || ramp.force_from != ramp.force_to || ramp.in_cycles != Vec3{})
      ramped_bodies.push_back(static_cast<int>(b));
    for (std::size_t c = 0; c < 3; ++c) {
      lanes.prescribed_velocity[c][lane] = ramp.velocity_from[c];
      lanes.applied_force[c][lane] = ramp.force_from[c];
    }
  }
  find_bodies_at_rest();
  rest_known = false;  // the end of the ramps may bring others to rest
}

void Simulation::Impl::find_bodies_at_rest() {
  for (BodyLanes& lanes : body_lanes) lanes.at_rest = scene.solver.skip_resting_bodies;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const auto [index, lane] = body_place[b];
    BodyLanes& lanes = body_lanes[static_cast<std::size_t>(index)];
    for (std::size_t c = 0; c < 3; ++c) {
      const bool held = (lanes.prescribed[c][lane] != 0.0 || model.bodies[b].held[c]) &&
                        (lanes.prescribed[3 + c][lane] != 0.0 || model.bodies[b].held[3 + c]);
      const bool still = lanes.velocity[c][lane] == 0.0 && lanes.spin[c][lane] == 0.0 &&
                         (controls_settled ? lanes.prescribed_velocity[c][lane] == 0.0
                                           : ramps[b].velocity_from[c] == 0.0 && ramps[b].velocity_to[c] == 0.0);
      lanes.at_rest = lanes.at_rest && held && still;
    }
  }
  rest_known = true;
}

void Simulation::Impl::choose_damping() {
  const bool settling = stage >= 0 && scene.stages[static_cast<std::size_t>(stage)].equilibrium_ratio;
  const SolverSettings& settings = scene.solver;
  if (riding) riding->settle(settling);
  data.local_damping = settling ? settings.settling_damping.value_or(settings.local_damping) : settings.local_damping;
}

void Simulation::Impl::find_loaded_blocks() {
  std::vector<int> place(model.groups.size(), -1);
  int count = 0;
  for (std::size_t i = 0; i < model.assembly.bricks.size(); ++i) {
    const Brick& brick = model.assembly.bricks[i];
    if (brick.rigid || brick.body.empty()) continue;
    LoadedBlock& loaded = loaded_blocks.emplace_back();
    loaded.block = static_cast<int>(i);
    model.for_each_gridpoint(loaded.block, [&](std::size_t, double mass) { loaded.mass += mass; });
    int& group = place[static_cast<std::size_t>(model.place[i].group)];
    if (group < 0) group = count++;
  }
  load.assign(static_cast<std::size_t>(count) * kLine, 0.0);
  for (const int group : place) load_of_group.push_back(group < 0 ? nullptr : load.data() + group * kLine);
  load_ramps.resize(loaded_blocks.size());
}

void Simulation::Impl::bind_whiffletree() {
  whiffletree.clear();
  if (stage < 0 || !scene.stages[static_cast<std::size_t>(stage)].whiffletree) return;
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  for (const auto& floor : settings.whiffletree->floors) {
    Floor& indices = whiffletree.emplace_back();
    for (const std::string& name : floor) {
      if (riding) {
        const std::vector<int> named = blocks_named(name, settings.source.text);
        indices.riding.insert(indices.riding.end(), named.begin(), named.end());
        continue;
      }
      const std::vector<int> named = model.bodies_named(name);
      indices.bodies.insert(indices.bodies.end(), named.begin(), named.end());
      bool found = !named.empty();
      for (std::size_t i = 0; i < loaded_blocks.size(); ++i) {
        if (model.assembly.bricks[static_cast<std::size_t>(loaded_blocks[i].block)].body != name) continue;
        indices.loaded.push_back(static_cast<int>(i));
        found = true;
      }
      if (!found)
        throw Error(Exit::bad_input, fmt::format("{}: stage '{}' pushes the body '{}', but the assembly has no block "
                                                 "of that name",
                                                 settings.source.text, settings.name, name));
    }
  }
}

long Simulation::Impl::chosen_record_interval() const {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  if (settings.record_interval > 0) return settings.record_interval;
  if (scene.output.record_interval > 0.0)
    return std::max(1L, std::lround(scene.output.record_interval / data.time_step));
  double steps = std::numeric_limits<double>::infinity();
  if (settings.duration) steps = *settings.duration / data.time_step;
  if (settings.displacement) {
    const auto direction = static_cast<std::size_t>(settings.direction);
    double speed = 0.0;
    if (settings.whiffletree)
      speed = std::abs(settings.whiffletree->velocity);
    else if (!monitor.empty())
      speed = std::abs(ramps[static_cast<std::size_t>(monitor.front())].velocity_to[direction]);
    for (const Drive& drive : drives) {
      if (!monitor_blocks.empty() && drive.block == monitor_blocks.front())
        speed = std::abs(drive.velocity_to[settings.direction]);
    }
    if (speed > 0.0)
      steps = std::min(steps, (*settings.displacement / speed + 0.5 * settings.ramp_time) / data.time_step);
  }
  if (settings.collapse)
    steps = std::min(
        steps, (settings.ramp_time + (settings.collapse->limit - settings.collapse->start) / settings.collapse->rate) /
                   data.time_step);
  if (!std::isfinite(steps)) return kUnknownLength;
  const long rows = cycles ? std::max(kDefaultRows, kHalfCycleRows * cycles->half_cycles()) : kDefaultRows;
  return std::max(1L, std::lround(steps / static_cast<double>(rows)));
}

double Simulation::Impl::stage_fraction() const {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  double fraction = 0.0;
  if (settings.duration) fraction = stage_time() / *settings.duration;
  if (settings.collapse) {
    // Where it will end is not known; the limit ends it for certain, and frames and progress go by it.
    const Collapse& c = *settings.collapse;
    fraction = std::max(fraction, std::min(1.0 - 1e-9, (multiplier - c.start) / (c.limit - c.start)));
  }
  if (settings.displacement && riding) {
    const auto c = static_cast<std::size_t>(settings.direction);
    fraction = std::max(fraction, std::abs((whiffletree.empty() ? riding_displacement(monitor_blocks)[c]
                                                                : floor_displacement_now(whiffletree.size() - 1)) -
                                           monitor_start[c]) /
                                      *settings.displacement);
  } else if (settings.displacement) {
    const auto c = static_cast<std::size_t>(settings.direction);
    const double now = whiffletree.empty() ? mean_of(monitor, &BodyLanes::displacement)[c]
                                           : floor_displacement(whiffletree.size() - 1);
    const double moved = std::abs(now - monitor_start[c]);
    fraction = std::max(fraction, moved / *settings.displacement);
  }
  return fraction;
}

bool Simulation::Impl::equilibrium_reached(const Stage& settings) {
  if (!settings.equilibrium_ratio) return false;
  const bool ramped = stage_time() >= settings.ramp_time;
  calm_checks = ramped && unbalanced_ratio <= *settings.equilibrium_ratio ? calm_checks + 1 : 0;
  return calm_checks >= kCalmChecks;
}

void Simulation::Impl::swap_law(const std::string& name, const std::string& law) {
  const auto& families = model.assembly.families;
  const auto found = std::find_if(families.begin(), families.end(), [&](const auto& f) { return f.name == name; });
  if (found == families.end()) {
    throw Error(Exit::bad_input, fmt::format("stage '{}' swaps the law of joint family '{}', which does not exist",
                                             scene.stages[static_cast<std::size_t>(stage)].name, name));
  }
  const auto f = static_cast<std::size_t>(found - families.begin());
  auto material = successor(*found, law);
  if (riding) return swap_riding_law(f, std::move(material));

  ContactFamily& family = model.families[f];
  const auto count = static_cast<std::size_t>(family.point_count), first = static_cast<std::size_t>(family.first_point);
  // The opening that belongs to the standing tractions: displacements have moved on by one step since.
  std::vector<double> opening(count);
  for (std::size_t i = 0; i < count; ++i) opening[i] = opening_at_traction(static_cast<std::int32_t>(first + i));
  FamilyColumns points;
  points.count = count;
  points.opening = opening.data();
  points.area = model.area.data() + first;
  for (std::size_t k = 0; k < 3; ++k) points.traction[k] = traction[k].data() + first;
  for (std::uint64_t k = 0; k < family.material->api().state_count; ++k)
    points.state.push_back(law_state[f].data() + k * count);
  MigratedFamily migrated = migrate(*found, *family.material, std::move(material), points);

  if (normal_shift.empty()) normal_shift.assign(static_cast<std::size_t>(model.point_count), 0.0);
  for (std::size_t i = 0; i < count; ++i) normal_shift[first + i] += migrated.opening_shift[i];
  swaps.push_back(migrated.report);
  family.material = std::move(migrated.material);
  law_state[f].assign(migrated.state.begin(), migrated.state.end());
  bind_columns();
}

// ---- Set-up --------------------------------------------------------------------------------------------------------

Simulation::Impl::Impl(Scene scene_in, Assembly assembly, int threads,
                       std::vector<std::shared_ptr<const Material>> materials, const blocks::Assembly* shapes)
    : scene(std::move(scene_in)),
      pool(threads > 0 ? threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
      want_energy(scene.output.energy),
      keep_diagnostics(scene.output.energy) {
  take_bricks(std::move(assembly), materials);
  for (const ContactFamily& family : model.families) first_materials.push_back(family.material);
  if (shapes) build_riding(*shapes, std::move(materials));
  bind_step();
}

void Simulation::Impl::bind_step() {
  data.time_step = time_step.time_step;
  data.internal_forces = scene.solver.internal_forces;
  data.energies = want_energy;
  data.damping = scene.solver.damping;
  data.mass_damping = scene.solver.damping == DampingKind::viscous ? scene.solver.mass_damping : 0.0;
  data.stiffness_damping = time_step.stiffness_damping;
  choose_damping();
  bind_columns();
  partition_work();
}

void Simulation::Impl::take_bricks(Assembly assembly, const std::vector<std::shared_ptr<const Material>>& materials) {
  model = Model(std::move(assembly), materials);
  inertia = {};
  time_step = {};
  if (!model.assembly.bricks.empty())
    time_step = choose_time_step(model, scene.solver, &inertia, Limits::critical, scene.stages);
  joint_sliding = JointSliding(model.assembly);
  normal_shift.clear();
  body_lanes.clear(), body_place.clear(), group_inertia.clear(), ramps.clear();
  loaded_blocks.clear(), load_of_group.clear(), load_ramps.clear();
  shared_dt_over_mass.clear(), inertia_tables.clear();
  law_state.clear(), calls.clear();
  monitor.clear(), ramped_bodies.clear(), whole_motions.clear();
  const auto doubles = static_cast<std::size_t>(model.line_count) * kLine;
  const auto points = static_cast<std::size_t>(model.point_count);
  displacement.assign(doubles, 0.0);
  velocity.assign(doubles, 0.0);
  for (auto& column : traction) column.assign(points, 0.0);
  for (auto& column : force) column.assign(points + kLanes, 0.0);
  flags.assign(points, 0);
  if (want_energy) {
    for (auto& column : energy_columns) column.assign(points, 0.0);
  }
  ramps.resize(model.bodies.size());
  find_loaded_blocks();
  measured.resize(model.unit_groups.size() + model.body_groups.size() + model.lone_bodies.size());
  body_lanes.resize(model.body_groups.size() + model.lone_bodies.size());
  body_place.resize(model.bodies.size());
  for (std::size_t g = 0; g < model.body_groups.size(); ++g) {
    const BodyGroup& group = model.body_groups[g];
    for (int lane = 0; lane < group.body_count; ++lane)
      body_place[static_cast<std::size_t>(group.body[static_cast<std::size_t>(lane)])] = {static_cast<int>(g), lane};
    group_inertia.push_back(inertia_of(group, model, inertia, time_step.time_step));
  }
  for (std::size_t i = 0; i < model.lone_bodies.size(); ++i)
    body_place[static_cast<std::size_t>(model.lone_bodies[i])] = {static_cast<int>(model.body_groups.size() + i), 0};

  dt_over_mass.assign(doubles, 0.0);
  for (std::size_t i = 0; i < doubles; ++i) {
    if (model.node_free[i] != 0.0 && inertia.node[i] > 0.0)
      dt_over_mass[i] = time_step.time_step / (inertia.deformation * inertia.node[i]);
  }
  share_inertia();
  for (std::size_t f = 0; f < model.families.size(); ++f) {
    const ContactFamily& family = model.families[f];
    const std::vector<double> initial = family.material->initial_state(model.assembly.families[f].initial_state);
    LaneVector<double> columns;
    for (double value : initial) columns.insert(columns.end(), static_cast<std::size_t>(family.point_count), value);
    law_state.push_back(std::move(columns));
  }
}

void Simulation::Impl::share_inertia() {
  for (const BlockGroup& group : model.groups) {
    std::vector<double> table;
    bool alike = true;
    for (int n = 0; n < model.templates[static_cast<std::size_t>(group.brick_template)].node_count; ++n) {
      for (int c = 0; c < 3; ++c) {
        const double* lane = dt_over_mass.data() + (group.first_line + n) * kLine + c * kLanes;
        table.push_back(lane[0]);
        alike = alike && std::all_of(lane, lane + group.block_count, [&](double x) { return x == lane[0]; });
      }
    }
    shared_dt_over_mass.push_back(alike ? inertia_tables.insert(std::move(table)).first->data() : nullptr);
  }
}

void Simulation::Impl::bind_columns() {
  data.displacement = displacement.data();
  data.velocity = velocity.data();
  data.dt_over_mass = dt_over_mass.data();
  data.shared_dt_over_mass = shared_dt_over_mass.data();
  data.load = load_of_group.data();
  data.deformation_inertia = inertia.deformation;
  data.unit_inertia = inertia.unit;
  data.block_motion = inertia.rigid.block.empty() ? nullptr : inertia.rigid.block.data();
  data.unit_motion = inertia.rigid.unit.empty() ? nullptr : inertia.rigid.unit.data();
  data.normal_shift = normal_shift.empty() ? nullptr : normal_shift.data();
  for (std::size_t k = 0; k < 3; ++k) {
    data.traction[k] = traction[k].data();
    data.force[k] = force[k].data();
  }
  calls.resize(model.chunks.size());
  for (std::size_t c = 0; c < model.chunks.size(); ++c) {
    const ContactChunk& chunk = model.chunks[c];
    const auto f = static_cast<std::size_t>(chunk.family);
    const ContactFamily& family = model.families[f];
    const quoin_law& law = family.material->api();
    LawCall& call = calls[c];
    call.state_old.clear();
    call.state_new.clear();
    for (std::uint64_t k = 0; k < law.state_count; ++k) {
      double* column = law_state[f].data() + k * static_cast<std::size_t>(family.point_count) +
                       (chunk.first_point - family.first_point);
      if (law.states[k]->role == QUOIN_ROLE_DIAGNOSTIC && !keep_diagnostics) column = nullptr;
      call.state_old.push_back({column, 1});
      call.state_new.push_back({column, 1});
    }
    call.batch = {};
    call.batch.struct_size = sizeof(quoin_batch);
    call.batch.count = static_cast<std::uint64_t>(chunk.point_count);
    for (std::size_t k = 0; k < 3; ++k) {
      call.batch.traction_old[k] = {traction[k].data() + chunk.first_point, 1};
      call.batch.traction_new[k] = {traction[k].data() + chunk.first_point, 1};
    }
    call.batch.state_old = call.state_old.data();
    call.batch.state_new = call.state_new.data();
    if (want_energy && (law.capabilities & QUOIN_CAN_ENERGY)) {
      call.batch.energy_stored = {energy_columns[0].data() + chunk.first_point, 1};
      for (std::size_t k = 0; k < 4; ++k)
        call.batch.dissipated[k] = {energy_columns[k + 1].data() + chunk.first_point, 1};
    }
  }
}

void Simulation::Impl::partition_work() {
  std::vector<double> weight;
  for (const ContactChunk& chunk : model.chunks) weight.push_back(chunk.point_count);
  for (int c = 0; riding && c < riding->chunk_count(); ++c) weight.push_back(riding->chunk_work(c));
  chunk_end = shares(weight, pool.thread_count());

  // One contact point of a lone body costs about as much as 20 coefficients of a group, 8 of a body group as 12.
  constexpr double kBodyPoint = 20.0, kBodySlot = 12.0;
  weight.clear();
  std::size_t largest = 0;
  for (const UnitGroup& unit : model.unit_groups) {
    weight.push_back(0.0);
    for (int g = unit.first_group; g < unit.first_group + unit.group_count; ++g) {
      const BlockGroup& group = model.groups[static_cast<std::size_t>(g)];
      const BrickTemplate& shape = model.templates[static_cast<std::size_t>(group.brick_template)];
      weight.back() += static_cast<double>(shape.coefficient.size());
      largest = std::max(largest, static_cast<std::size_t>(shape.node_count) * kLine);
    }
  }
  for (const BodyGroup& group : model.body_groups)
    weight.push_back(kBodySlot * (model.body_slots[static_cast<std::size_t>(group.slots)].slot_count() + 8.0));
  for (const int b : model.lone_bodies)
    weight.push_back(kBodyPoint * (static_cast<double>(model.bodies[static_cast<std::size_t>(b)].point.size()) + 2.0));
  for (int b = 0; riding && b < riding->block_count(); ++b) weight.push_back(riding->block_work(b));
  item_end = shares(weight, pool.thread_count());
  data.scratch_doubles = kScratchColumns * largest;
  for (int t = static_cast<int>(scratch.size()); t < pool.thread_count(); ++t) {
    scratch.emplace_back(kUnitBlocks * data.scratch_doubles, 0.0);
    jumps.push_back(std::make_unique<ChunkJumps>());
  }
}

// ---- The public class ----------------------------------------------------------------------------------------------

Simulation::Simulation(Scene scene, int threads) {
  Motion motion = choose_motion(std::move(scene));
  auto materials = make_materials(motion.bricks);
  impl_ = make_impl(std::move(motion), threads, std::move(materials));
}

Simulation::Simulation(Scene scene, Assembly assembly, int threads) {
  auto materials = make_materials(assembly);
  impl_ = make_impl(choose_motion(std::move(scene), std::move(assembly)), threads, std::move(materials));
}

Simulation::Simulation(Scene scene, Assembly assembly, int threads,
                       std::vector<std::shared_ptr<const Material>> materials)
    : impl_(make_impl(choose_motion(std::move(scene), std::move(assembly)), threads, std::move(materials))) {}

std::unique_ptr<Simulation::Impl> Simulation::make_impl(Motion motion, int threads,
                                                        std::vector<std::shared_ptr<const Material>> materials) {
  return std::make_unique<Impl>(std::move(motion.scene), std::move(motion.bricks), threads, std::move(materials),
                                motion.shapes ? &*motion.shapes : nullptr);
}

Simulation::~Simulation() = default;

void Simulation::advance(long steps, bool measure_last) {
  if (impl_->stage < 0 && !impl_->scene.stages.empty()) impl_->begin_stage(0);
  for (long i = 0; i < steps; ++i) {
    const bool last = measure_last && i + 1 == steps;
    impl_->step_once(impl_->want_energy || last, last);
  }
}

void Simulation::run(Observer& observer) {
  Impl& s = *impl_;
  const int stage_count = static_cast<int>(s.scene.stages.size());
  const int first = s.stage < 0 ? 0 : s.in_stage ? s.stage : s.stage + 1;
  for (int index = first; index < stage_count; ++index) {
    if (!s.in_stage) s.begin_stage(index);
    observer.on_stage_begin(*this, index);
    for (const LawSwap& swap : s.swaps) observer.on_law_swap(swap);
    const Stage& settings = s.scene.stages[static_cast<std::size_t>(index)];
    const int frames = index + 1 == stage_count ? s.scene.output.frames : 0;
    auto last_progress = Clock::now();
    long steps_then = s.stage_step;
    double fraction_then = s.stage_fraction();

    for (bool done = false; !done;) {
      const bool stop = stop_requested();
      const bool check = settings.equilibrium_ratio && s.stage_step % kCheckInterval == 0;
      const bool due = s.stage_step >= s.next_row, row = stop || due;
      const bool frame = frames > 0 && s.next_frame <= frames && s.stage_fraction() * frames >= s.next_frame;
      s.step_once(check || row || frame || s.want_energy, frame);

      done = check && s.equilibrium_reached(settings);
      if (s.stage_fraction() >= 1.0 || s.force_lost()) done = true;
      if (s.riding && s.stage_step % kCollapseInterval == 0 && s.collapse_ended()) done = true;
      if (done && !frame) s.step_once(true, true);  // so that the last row and what follows it are complete
      // Before a row that only the stop asks for: who goes on from here has a history without it.
      if (stop && !due && !done && !frame) observer.on_pause(*this, true);
      if (row || done) {
        const HistoryRow now = s.measure();
        s.require_finite(now);
        observer.on_row(now);
        const bool was_past = !s.past_motion_bound().empty();
        s.look_at_motion();
        const std::string past = s.past_motion_bound();
        const SolverSettings& solver = s.scene.solver;
        if (!past.empty() && solver.large_motion == LargeMotion::never && solver.motion_bound.stop) {
          throw Error(
              Exit::numerical,
              fmt::format("step {} of stage '{}': {}. Choose solver.large_motion = \"always\", a shorter stage, "
                          "or solver.past_motion_bound = \"warn\" to go on all the same",
                          s.stage_step, settings.name, past));
        }
        if (!past.empty() && !s.riding && !s.outcome.promotion && solver.large_motion == LargeMotion::automatic) {
          s.promote(past);
          observer.on_promotion(*this);
        } else if (!past.empty() && !was_past && solver.large_motion != LargeMotion::always) {
          observer.on_motion_bound(past);
        }
        while (s.next_row < s.stage_step) s.next_row += s.row_interval;
      }
      if (frame) observer.on_frame(*this, index, s.next_frame++);
      if (stop)
        throw Error(Exit::interrupted, fmt::format("stopped at step {} of stage '{}'", s.stage_step, settings.name));
      if (!done && s.stage_step >= settings.max_steps) {
        std::string reason = fmt::format("stage '{}' has not ended after {} steps", settings.name, s.stage_step);
        if (settings.equilibrium_ratio) {
          reason += fmt::format(": unbalanced force ratio {:.4g}, wanted {:.4g}", s.unbalanced_ratio,
                                *settings.equilibrium_ratio);
        }
        throw Error(Exit::numerical, reason + ". Raise max_steps, or find out what keeps moving");
      }
      if (!done && s.stage_step % kPauseInterval == 0) observer.on_pause(*this, false);
      if ((s.stage_step & 63) == 0 && seconds_since(last_progress) >= kProgressPeriod) {
        const double seconds = seconds_since(last_progress);
        Progress progress;
        progress.stage = index;
        progress.stage_count = stage_count;
        progress.settings = &settings;
        progress.step = s.stage_step;
        progress.unbalanced_ratio = s.unbalanced_ratio;
        const double by_length = s.stage_fraction();
        progress.fraction = by_length;
        if (settings.equilibrium_ratio && s.unbalanced_ratio > 0.0 && std::isfinite(s.unbalanced_ratio) &&
            *settings.equilibrium_ratio < 1.0) {
          progress.fraction = std::max(by_length, std::log(s.unbalanced_ratio) / std::log(*settings.equilibrium_ratio));
        }
        progress.fraction = std::clamp(progress.fraction, 0.0, 1.0);
        progress.steps_per_second = static_cast<double>(s.stage_step - steps_then) / seconds;
        progress.seconds_left =
            by_length > fraction_then ? seconds * (1.0 - by_length) / (by_length - fraction_then) : -1.0;
        observer.on_progress(progress);
        last_progress = Clock::now();
        steps_then = s.stage_step;
        fraction_then = by_length;
      }
    }
    // Frames that the end overtook: the last one shows the end.
    if (frames > 0 && s.next_frame <= frames) observer.on_frame(*this, index, s.next_frame++);
    s.in_stage = false;
    observer.on_stage_end(*this, index, s.measure());
  }
}

void Simulation::time_phases(bool on) {
  impl_->timing = on;
  impl_->times = {};
}
PhaseTimes Simulation::phase_times() const { return impl_->times; }
const Scene& Simulation::scene() const { return impl_->scene; }
const Assembly& Simulation::assembly() const { return impl_->model.assembly; }
const Model& Simulation::model() const { return impl_->model; }
const TimeStepReport& Simulation::time_step_report() const { return impl_->time_step; }
long Simulation::step() const { return impl_->step_count; }
double Simulation::time() const { return impl_->now(); }
const blocks::Model* Simulation::riding() const { return impl_->riding.get(); }
geometry::Vector Simulation::riding_start(int block) const {
  return impl_->riding_start[static_cast<std::size_t>(block)];
}
const Outcome& Simulation::outcome() const { return impl_->outcome; }
int Simulation::thread_count() const { return impl_->pool.thread_count(); }
const char* Simulation::instruction_set() const { return kernel_instruction_set(); }
HistoryRow Simulation::measure() const { return impl_->measure(); }
const MotionSeen& Simulation::motion_seen() const { return impl_->motion_seen; }
std::string Simulation::past_motion_bound() const { return impl_->past_motion_bound(); }
LaneVector<double>& Simulation::displacement() { return impl_->displacement; }
LaneVector<double>& Simulation::velocity() { return impl_->velocity; }

}  // namespace quoin
