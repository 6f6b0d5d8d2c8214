#include "step/controls.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/smooth_step.h"
#include "step/actions/actions.h"
#include "step/actions/ground.h"
#include "step/actions/whiffletree.h"
#include "step/lattice_motion.h"
#include "step/measure.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/watched_motion.h"

namespace quoin {

namespace {

void follow_ramps(Simulation::Impl& s) {
  const double ramp = s.progress.stage >= 0 ? current_stage(s).ramp_time : 0.0;
  const double elapsed = s.large_motion ? stage_time(s) + 0.5 * s.large_motion->stepping.dt
                                        : (static_cast<double>(s.progress.stage_step) + 0.5) * s.data.time_step;
  const bool shakes = s.progress.stage >= 0 && current_stage(s).ground.has_value();
  const double gone = ramp > 0.0 ? smooth_step(elapsed / ramp) : 1.0;
  const auto between = [gone](double from, double to) { return gone >= 1.0 ? to : from + gone * (to - from); };
  for (const int body : s.controls.ramped_bodies) {
    const auto b = static_cast<std::size_t>(body);
    const auto [index, lane] = s.lattice.place[b];
    BodyLanes& lanes = s.lattice.bodies[static_cast<std::size_t>(index)];
    Vec3 record{};
    if (shakes && s.controls.ramps[b].of_ground != 0)
      record = geometry::array(record_velocity(s, current_stage(s), time_now(s) + 0.5 * s.data.time_step,
                                               static_cast<std::int32_t>(s.controls.ramps[b].motion)));
    for (std::size_t c = 0; c < 3; ++c) {
      lanes.prescribed_velocity[c][lane] =
          s.controls.ramps[b].in_cycles[c] != 0.0
              ? velocity_in_cycles(s, s.controls.ramps[b].velocity_from[c])
              : between(s.controls.ramps[b].velocity_from[c], s.controls.ramps[b].velocity_to[c]) +
                    (s.controls.ramps[b].of_ground >> c & 1 ? record[c] : 0.0);
      lanes.applied_force[c][lane] = between(s.controls.ramps[b].force_from[c], s.controls.ramps[b].force_to[c]);
    }
  }
  for (std::size_t i = 0; i < s.controls.loaded_blocks.size(); ++i) {
    LoadRamp& of_block = s.controls.load_ramps[i];
    for (std::size_t c = 0; c < 3; ++c) of_block.now[c] = between(of_block.from[c], of_block.to[c]);
    s.controls.apply_load(s.model, i);
  }
  for (std::size_t c = 0; c < 3; ++c) s.data.gravity[c] = between(s.controls.gravity_from[c], s.controls.gravity_to[c]);
  if (!s.large_motion) follow_ground_of_lattice(s);
  // The velocity of the ground for damping is that of half a step ago.
  s.controls.settled =
      elapsed - s.data.time_step >= ramp && !(s.controls.cycles && !current_stage(s).whiffletree) && !shakes;
  if (s.large_motion) apply_actions(s, gone);
}

// motion: as in Drive, for a body that moves with the ground. left_over: velocity of the ground, m/s.
void control_body(Simulation::Impl& s, std::size_t b, const Stage& settings, const Stage* previous, std::int32_t motion,
                  const Vec3& left_over) {
  const auto [place, lane] = s.lattice.place[b];
  BodyLanes& body = s.lattice.bodies[static_cast<std::size_t>(place)];
  const Vec3 joints = joint_wrench(s, static_cast<int>(b)).force;
  const auto control = std::find_if(settings.controls.begin(), settings.controls.end(), [&](const BodyControl& c) {
    return !c.body.empty() && c.body == s.model.bodies[b].name;
  });
  const bool controlled = control != settings.controls.end();
  const std::uint64_t was_ground = s.controls.ramps[b].of_ground;
  const bool ground = !controlled && s.model.assembly.bricks[static_cast<std::size_t>(s.model.bodies[b].block)].fixed;
  const Vec3 goes_on = was_ground != 0 ? left_over_velocity(s, previous, static_cast<int>(b)) : left_over;
  s.controls.ramps[b].of_ground = ground ? kOfGround : 0;
  s.controls.ramps[b].motion = ground && settings.ground ? motion : ground ? s.controls.ramps[b].motion : 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool was_prescribed = body.prescribed[c][lane] != 0.0;
    const bool prescribed = ground || (controlled && control->kind[c] == DofKind::velocity);
    // A newly freed component starts from the reaction of its support.
    const double carried =
        was_prescribed ? -joints[c] - s.model.bodies[b].mass * s.data.gravity[c] : body.applied_force[c][lane];
    s.controls.ramps[b].velocity_from[c] = was_prescribed ? body.prescribed_velocity[c][lane] : body.velocity[c][lane];
    if (was_ground >> c & 1) s.controls.ramps[b].velocity_from[c] = goes_on[c];
    s.controls.ramps[b].velocity_to[c] = controlled && prescribed              ? control->velocity[c]
                                         : ground && settings.ramp_time <= 0.0 ? goes_on[c]
                                                                               : 0.0;
    s.controls.ramps[b].force_from[c] = prescribed ? 0.0 : carried;
    s.controls.ramps[b].force_to[c] = controlled && !prescribed ? control->force[c] : 0.0;
    s.controls.ramps[b].in_cycles[c] = controlled && control->in_cycles == static_cast<int>(c) ? 1.0 : 0.0;
    const bool was_held = body.prescribed[c + 3][lane] != 0.0, held = ground || (controlled && !control->may_turn);
    // Driven bodies are not part of the kinetic energy. A body that is released adds its own; one that is caught gives
    // it to the support.
    const double linear = 0.5 * s.inertia.in_use.body_mass[b] * body.velocity[c][lane] * body.velocity[c][lane];
    const double angular = 0.5 * s.inertia.in_use.body_inertia[b][c] * body.spin[c][lane] * body.spin[c][lane];
    s.energy.external += (was_prescribed - prescribed) * linear + (was_held - held) * angular;
    body.prescribed_velocity[c][lane] = s.controls.ramps[b].velocity_from[c];
    body.applied_force[c][lane] = s.controls.ramps[b].force_from[c];
    body.prescribed[c][lane] = prescribed ? 1.0 : 0.0;
    body.prescribed[c + 3][lane] = held ? 1.0 : 0.0;
  }
}

}  // namespace

void apply_controls(Simulation::Impl& s) {
  if (!s.controls.settled)
    follow_ramps(s);
  else if (s.large_motion && (current_stage(s).collapse || current_stage(s).moving_load))
    apply_actions(s, 1.0);  // these change after the ramp; all others are constant
  else if (!s.controls.rest_known)
    find_bodies_at_rest(s);
  if (s.progress.stage >= 0 && current_stage(s).whiffletree) pull_whiffletree(s);
}

double velocity_in_cycles(const Simulation::Impl& s, double initial_velocity) {
  const double dt = s.data.time_step, t = stage_time(s);
  return (s.controls.cycles->position(t + dt, initial_velocity) - s.controls.cycles->position(t, initial_velocity)) /
         dt;
}

// Also finds deformable blocks, in stages with ground motion.
void find_monitor(Simulation::Impl& s, const Stage& settings) {
  std::vector<int> found = blocks_on_lattice(s, settings.monitor);
  const auto is_deformable = [&s](int block) { return s.model.place[at(block)].body < 0; };
  if (!settings.ground || !std::ranges::all_of(found, is_deformable)) std::erase_if(found, is_deformable);
  if (!settings.monitor.empty() && found.empty()) {
    throw Error(Exit::bad_input,
                fmt::format("{}: stage '{}' monitors the body '{}', but the assembly has no rigid block of that "
                            "name",
                            settings.source.text, settings.name, settings.monitor));
  }
  if (settings.displacement && found.empty()) {
    throw Error(Exit::bad_input, fmt::format("{}: stage '{}' ends by displacement but has no monitor body",
                                             settings.source.text, settings.name));
  }
  s.monitor.blocks = std::move(found);
  s.monitor.points.clear();
  if (!std::ranges::any_of(s.monitor.blocks, is_deformable)) return;
  std::vector<char> watched(s.model.assembly.bricks.size(), 0);
  for (const int block : s.monitor.blocks) watched[at(block)] = 1;
  for (std::int32_t p = 0; p < s.model.point_count; ++p) {
    const Model::Sides sides = s.model.sides_of(p);
    const bool a = watched[at(sides.a)] != 0, b = watched[at(sides.b)] != 0;
    if (a != b) s.monitor.points.push_back({p, a ? 1.0 : -1.0});
  }
}

// The ground consists of all fixed bricks that no table of the stage controls (step/actions/ground.cpp).
void control_bodies(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  for (const BodyControl& control : settings.controls) {
    const bool deformable = !s.model.deformable_blocks_named(control.body).empty();
    if (s.model.bodies_named(control.body).empty() && !deformable) {
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
  find_monitor(s, settings);
  const int ground = s.controls.ground_body();
  const Vec3 left_over = ground >= 0 ? left_over_velocity(s, previous, ground) : Vec3{};
  const std::vector<std::int32_t> motions = support_groups(s, settings);
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b)
    control_body(s, b, settings, previous, motions[static_cast<std::size_t>(s.model.bodies[b].block)], left_over);
  for (std::size_t i = 0; i < s.controls.loaded_blocks.size(); ++i) {
    const std::string& name = s.model.assembly.bricks[static_cast<std::size_t>(s.controls.loaded_blocks[i].block)].body;
    const auto control = std::find_if(settings.controls.begin(), settings.controls.end(),
                                      [&](const BodyControl& c) { return c.body == name; });
    s.controls.load_ramps[i].from = s.controls.load_ramps[i].now;
    s.controls.load_ramps[i].to = control != settings.controls.end() ? control->force : Vec3{};
  }
  s.monitor.start = displacement_now(s, s.monitor.blocks);
}

void bind_controls(Simulation::Impl& s) {
  s.controls.cycles.reset();
  if (s.progress.stage >= 0 && current_stage(s).cycles) s.controls.cycles.emplace(*current_stage(s).cycles);
  s.controls.ramped_bodies.clear();
  for (BodyLanes& lanes : s.lattice.bodies) lanes.any_prescribed = false;
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b) {
    const auto [index, lane] = s.lattice.place[b];
    BodyLanes& lanes = s.lattice.bodies[static_cast<std::size_t>(index)];
    for (const auto& prescribed : lanes.prescribed)
      lanes.any_prescribed = lanes.any_prescribed || prescribed[lane] != 0.0;
    const BodyRamp& ramp = s.controls.ramps[b];
    if (ramp.velocity_from != ramp.velocity_to || ramp.force_from != ramp.force_to || ramp.in_cycles != Vec3{} ||
        ramp.of_ground != 0)
      s.controls.ramped_bodies.push_back(static_cast<int>(b));
  }
  find_bodies_at_rest(s);
  s.controls.rest_known = false;  // other bodies may be at rest when ramps end
}

void find_bodies_at_rest(Simulation::Impl& s) {
  const bool shakes = s.progress.stage >= 0 && current_stage(s).ground.has_value();
  for (BodyLanes& lanes : s.lattice.bodies) lanes.at_rest = s.scene.solver.skip_resting_bodies;
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b) {
    const auto [index, lane] = s.lattice.place[b];
    BodyLanes& lanes = s.lattice.bodies[static_cast<std::size_t>(index)];
    for (std::size_t c = 0; c < 3; ++c) {
      const bool held = (lanes.prescribed[c][lane] != 0.0 || s.model.bodies[b].held[c]) &&
                        (lanes.prescribed[3 + c][lane] != 0.0 || s.model.bodies[b].held[3 + c]);
      const bool still = lanes.velocity[c][lane] == 0.0 && lanes.spin[c][lane] == 0.0 &&
                         (s.controls.settled ? lanes.prescribed_velocity[c][lane] == 0.0
                                             : s.controls.ramps[b].velocity_from[c] == 0.0 &&
                                                   s.controls.ramps[b].velocity_to[c] == 0.0 &&
                                                   !(shakes && s.controls.ramps[b].of_ground != 0));
      lanes.at_rest = lanes.at_rest && held && still;
    }
  }
  s.controls.rest_known = true;
}

}  // namespace quoin
