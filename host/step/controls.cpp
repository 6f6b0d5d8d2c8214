#include "step/controls.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/smooth_step.h"
#include "step/actions/actions.h"
#include "step/block_motion.h"
#include "step/monitor.h"
#include "step/reactions.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

void follow_ramps(Simulation::Impl& s) {
  const double ramp = current_stage(s).ramp_time;
  const double elapsed = s.large_motion ? stage_time(s) + 0.5 * s.large_motion->stepping.dt
                                        : (static_cast<double>(s.progress.stage_step) + 0.5) * s.data.time_step;
  const double gone = ramp > 0.0 ? smooth_step(elapsed / ramp) : 1.0;
  for (std::size_t c = 0; c < 3; ++c)
    s.data.gravity[c] =
        gone >= 1.0 ? s.controls.gravity_to[c]
                    : s.controls.gravity_from[c] + gone * (s.controls.gravity_to[c] - s.controls.gravity_from[c]);
  // The velocity of the ground for damping is that of half a step ago.
  s.controls.settled = elapsed - s.data.time_step >= ramp && !(s.controls.cycles && !current_stage(s).whiffletree) &&
                       !current_stage(s).ground;
  apply_actions(s, gone);
}

void require_bodies_on_lattice(const Simulation::Impl& s, const Stage& settings) {
  for (const BodyControl& control : settings.controls) {
    const std::vector<int> named = s.model.blocks_named(control.body);
    const bool deformable = std::ranges::any_of(named, [&](int block) { return s.model.place[at(block)].body < 0; });
    if (named.empty()) {
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

void control_bricks(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  require_bodies_on_lattice(s, settings);
  watch_blocks(s, settings);
  remove_forces(s);
  bind_actions(s, settings, previous);
  s.monitor.start = displacement_now(s, s.monitor.blocks);
}

void bind_controls(Simulation::Impl& s) {
  s.controls.cycles.reset();
  if (s.progress.stage >= 0 && current_stage(s).cycles) s.controls.cycles.emplace(*current_stage(s).cycles);
  find_bodies_at_rest(s);
}

void find_bodies_at_rest(Simulation::Impl& s) {
  s.controls.rest_known = s.controls.settled;  // else other bodies may be at rest when ramps end
  if (s.lattice.bodies.empty()) return;
  const bool shakes = s.progress.stage >= 0 && current_stage(s).ground.has_value();
  const std::vector<std::uint8_t> held = held_now(s);
  std::vector<bool> moves(held.size(), false);  // by its drive
  const auto some = [](const geometry::Vector& v) { return norm(v) > 0.0; };
  for (const Drive& d : s.actions.drives)
    moves[at(d.block)] = s.controls.settled ? some(d.velocity_to) || some(d.omega_to)
                                            : some(d.velocity_from) || some(d.velocity_to) || some(d.omega_from) ||
                                                  some(d.omega_to) || (shakes && d.of_ground);
  for (BodyLanes& lanes : s.lattice.bodies) lanes.at_rest = s.scene.solver.skip_resting_bodies;
  for (std::size_t b = 0; b < s.model.bodies.size(); ++b) {
    const auto [index, lane] = s.lattice.place[b];
    const RigidBody& body = s.model.bodies[b];
    BodyLanes& lanes = s.lattice.bodies[static_cast<std::size_t>(index)];
    bool rests = !moves[at(body.block)];
    for (std::size_t c = 0; c < 6; ++c) rests = rests && ((held[at(body.block)] >> c & 1) != 0 || body.held[c]);
    for (std::size_t c = 0; c < 3; ++c) rests = rests && lanes.velocity[c][lane] == 0.0 && lanes.spin[c][lane] == 0.0;
    lanes.at_rest = lanes.at_rest && rests;
  }
}

}  // namespace quoin
