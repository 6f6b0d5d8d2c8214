// What acts on bodies and blocks in a stage: imposed velocities, forces, gravity, the whiffletree.
#include <fmt/core.h>

#include <algorithm>

#include "step/state.h"

namespace quoin {

void Simulation::Impl::apply_controls() {
  if (!controls_settled)
    follow_ramps();
  else if (large_motion && (scene.stages[static_cast<std::size_t>(stage)].collapse ||
                            scene.stages[static_cast<std::size_t>(stage)].moving_load))
    apply_actions(1.0);  // these go on changing; all else stays as the end of the ramp has left it
  else if (!rest_known)
    find_bodies_at_rest();
  if (!whiffletree.empty()) pull_whiffletree();
}

double Simulation::Impl::mean_along_x(const LoadedBlock& block, const LaneVector<double>& field) const {
  double sum = 0.0;
  model.for_each_gridpoint(block.block, [&](std::size_t offset, double mass) { sum += mass * field[offset]; });
  return sum / block.mass;
}

void Simulation::Impl::apply_load(std::size_t loaded) {
  const LoadedBlock& block = loaded_blocks[loaded];
  const Model::BlockPlace& where = model.place[static_cast<std::size_t>(block.block)];
  const auto first = static_cast<std::size_t>(load_of_group[static_cast<std::size_t>(where.group)] - load.data());
  for (std::size_t c = 0; c < 3; ++c)
    load[first + c * kLanes + static_cast<std::size_t>(where.lane)] = load_ramps[loaded].now[c] / block.mass;
}

void Simulation::Impl::follow_ramps() {
  const double ramp = stage >= 0 ? scene.stages[static_cast<std::size_t>(stage)].ramp_time : 0.0;
  const double elapsed = large_motion ? stage_time() + 0.5 * large_motion->time_step()
                                      : (static_cast<double>(stage_step) + 0.5) * data.time_step;
  const bool shakes = stage >= 0 && scene.stages[static_cast<std::size_t>(stage)].ground.has_value();
  const double s = ramp > 0.0 ? smooth_step(elapsed / ramp) : 1.0;
  const auto between = [s](double from, double to) { return s >= 1.0 ? to : from + s * (to - from); };
  for (const int body : ramped_bodies) {
    const auto b = static_cast<std::size_t>(body);
    const auto [index, lane] = body_place[b];
    BodyLanes& lanes = body_lanes[static_cast<std::size_t>(index)];
    Vec3 record{};
    if (shakes && ramps[b].of_ground != 0)
      record = geometry::array(record_velocity(scene.stages[at_stage()], now() + 0.5 * data.time_step,
                                               static_cast<std::int32_t>(ramps[b].motion)));
    for (std::size_t c = 0; c < 3; ++c) {
      lanes.prescribed_velocity[c][lane] = ramps[b].in_cycles[c] != 0.0
                                               ? velocity_in_cycles(ramps[b].velocity_from[c])
                                               : between(ramps[b].velocity_from[c], ramps[b].velocity_to[c]) +
                                                     (ramps[b].of_ground >> c & 1 ? record[c] : 0.0);
      lanes.applied_force[c][lane] = between(ramps[b].force_from[c], ramps[b].force_to[c]);
    }
  }
  for (std::size_t i = 0; i < loaded_blocks.size(); ++i) {
    LoadRamp& of_block = load_ramps[i];
    for (std::size_t c = 0; c < 3; ++c) of_block.now[c] = between(of_block.from[c], of_block.to[c]);
    apply_load(i);
  }
  for (std::size_t c = 0; c < 3; ++c) data.gravity[c] = between(gravity_from[c], gravity_to[c]);
  if (!large_motion) follow_ground_of_lattice(s);
  controls_settled = s >= 1.0 && !(cycles && whiffletree.empty()) && !shakes;
  if (large_motion) apply_actions(s);
}

double Simulation::Impl::velocity_in_cycles(double initial_velocity) const {
  const double dt = data.time_step, t = stage_time();
  return (cycles->position(t + dt, initial_velocity) - cycles->position(t, initial_velocity)) / dt;
}

// Deformable blocks too, of a stage in which the ground moves.
void Simulation::Impl::find_monitor(const Stage& settings) {
  const std::vector<int> found = model.bodies_named(settings.monitor);
  std::vector<int> loaded;
  for (std::size_t i = 0; i < loaded_blocks.size() && settings.ground && found.empty(); ++i) {
    if (model.assembly.bricks[static_cast<std::size_t>(loaded_blocks[i].block)].body == settings.monitor)
      loaded.push_back(static_cast<int>(i));
  }
  if (!settings.monitor.empty() && found.empty() && loaded.empty()) {
    throw Error(Exit::bad_input,
                fmt::format("{}: stage '{}' monitors the body '{}', but the assembly has no rigid block of that "
                            "name",
                            settings.source.text, settings.name, settings.monitor));
  }
  if (settings.displacement && found.empty() && loaded.empty()) {
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}' ends by displacement but has no monitor body",
                                             settings.source.text, settings.name));
  }
  monitor = found, monitor_loaded = std::move(loaded);
  monitor_points.clear();
  std::vector<char> watched(monitor_loaded.empty() ? 0 : model.assembly.bricks.size(), 0);
  for (const int i : monitor_loaded)
    watched[static_cast<std::size_t>(loaded_blocks[static_cast<std::size_t>(i)].block)] = 1;
  for (std::int32_t p = 0; !watched.empty() && p < model.point_count; ++p) {
    const Model::Sides sides = model.sides_of(p);
    const bool a = watched[static_cast<std::size_t>(sides.a)] != 0, b = watched[static_cast<std::size_t>(sides.b)] != 0;
    if (a != b) monitor_points.push_back({p, a ? 1.0 : -1.0});
  }
}

// The ground is all fixed bricks that no table of the stage controls (step/actions/ground.cpp).
void Simulation::Impl::control_bodies(const Stage& settings, const Stage* previous) {
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
  find_monitor(settings);
  const int ground = ground_body();
  const Vec3 left_over = ground >= 0 ? left_over_velocity(previous, ground) : Vec3{};
  const std::vector<std::int32_t> motions = support_groups(settings);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    control_body(b, settings, previous, motions[static_cast<std::size_t>(model.bodies[b].block)], left_over);
  for (std::size_t i = 0; i < loaded_blocks.size(); ++i) {
    const std::string& name = model.assembly.bricks[static_cast<std::size_t>(loaded_blocks[i].block)].body;
    const auto control = std::find_if(settings.controls.begin(), settings.controls.end(),
                                      [&](const BodyControl& c) { return c.body == name; });
    load_ramps[i].from = load_ramps[i].now;
    load_ramps[i].to = control != settings.controls.end() ? control->force : Vec3{};
  }
  monitor_start = mean_of(monitor, &BodyLanes::displacement);
  for (const int i : monitor_loaded) {
    const Vec3 moved = displacement_of_loaded(i);
    for (std::size_t c = 0; c < 3; ++c) monitor_start[c] += moved[c] / static_cast<double>(monitor_loaded.size());
  }
}

void Simulation::Impl::control_body(std::size_t b, const Stage& settings, const Stage* previous, std::int32_t motion,
                                    const Vec3& left_over) {
  const auto [place, lane] = body_place[b];
  BodyLanes& body = body_lanes[static_cast<std::size_t>(place)];
  const Vec3 joints = joint_force(static_cast<int>(b));
  const auto control = std::find_if(settings.controls.begin(), settings.controls.end(), [&](const BodyControl& c) {
    return !c.body.empty() && c.body == model.bodies[b].name;
  });
  const bool controlled = control != settings.controls.end(), was_ground = ramps[b].of_ground != 0;
  const bool ground = !controlled && (settings.ground || was_ground) &&
                      model.assembly.bricks[static_cast<std::size_t>(model.bodies[b].block)].fixed;
  const Vec3 goes_on = was_ground ? left_over_velocity(previous, static_cast<int>(b)) : left_over;
  ramps[b].of_ground = ground ? 7 : 0;
  ramps[b].motion = ground && settings.ground ? motion : ground ? ramps[b].motion : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool was_prescribed = body.prescribed[c][lane] != 0.0;
    const bool prescribed = ground || (controlled && control->kind[c] == DofKind::velocity);
    // What a support has carried so far is the force from which a newly freed component starts.
    const double carried =
        was_prescribed ? -joints[c] - model.bodies[b].mass * data.gravity[c] : body.applied_force[c][lane];
    ramps[b].velocity_from[c] = was_prescribed ? body.prescribed_velocity[c][lane] : body.velocity[c][lane];
    if (was_ground) ramps[b].velocity_from[c] = goes_on[c];
    ramps[b].velocity_to[c] = controlled && prescribed              ? control->velocity[c]
                              : ground && settings.ramp_time <= 0.0 ? goes_on[c]
                                                                    : 0.0;
    ramps[b].force_from[c] = prescribed ? 0.0 : carried;
    ramps[b].force_to[c] = controlled && !prescribed ? control->force[c] : 0.0;
    ramps[b].in_cycles[c] = controlled && control->in_cycles == static_cast<int>(c) ? 1.0 : 0.0;
    const bool was_held = body.prescribed[c + 3][lane] != 0.0, held = ground || (controlled && !control->may_turn);
    // The motion of what is driven is no kinetic energy: what is let go has its own, what is caught leaves it to the
    // support.
    const double linear = 0.5 * model.bodies[b].mass * body.velocity[c][lane] * body.velocity[c][lane];
    const double angular = 0.5 * model.bodies[b].inertia[c] * body.spin[c][lane] * body.spin[c][lane];
    energy_external += (was_prescribed - prescribed) * linear + (was_held - held) * angular;
    body.prescribed_velocity[c][lane] = ramps[b].velocity_from[c];
    body.applied_force[c][lane] = ramps[b].force_from[c];
    body.prescribed[c][lane] = prescribed ? 1.0 : 0.0;
    body.prescribed[c + 3][lane] = held ? 1.0 : 0.0;
  }
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
    if (ramp.velocity_from != ramp.velocity_to || ramp.force_from != ramp.force_to || ramp.in_cycles != Vec3{} ||
        ramp.of_ground != 0)
      ramped_bodies.push_back(static_cast<int>(b));
  }
  find_bodies_at_rest();
  rest_known = false;  // at the end of the ramps others may be at rest
}

void Simulation::Impl::find_bodies_at_rest() {
  const bool shakes = stage >= 0 && scene.stages[static_cast<std::size_t>(stage)].ground.has_value();
  for (BodyLanes& lanes : body_lanes) lanes.at_rest = scene.solver.skip_resting_bodies;
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const auto [index, lane] = body_place[b];
    BodyLanes& lanes = body_lanes[static_cast<std::size_t>(index)];
    for (std::size_t c = 0; c < 3; ++c) {
      const bool held = (lanes.prescribed[c][lane] != 0.0 || model.bodies[b].held[c]) &&
                        (lanes.prescribed[3 + c][lane] != 0.0 || model.bodies[b].held[3 + c]);
      const bool still = lanes.velocity[c][lane] == 0.0 && lanes.spin[c][lane] == 0.0 &&
                         (controls_settled ? lanes.prescribed_velocity[c][lane] == 0.0
                                           : ramps[b].velocity_from[c] == 0.0 && ramps[b].velocity_to[c] == 0.0 &&
                                                 !(shakes && ramps[b].of_ground != 0));
      lanes.at_rest = lanes.at_rest && held && still;
    }
  }
  rest_known = true;
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

}  // namespace quoin
