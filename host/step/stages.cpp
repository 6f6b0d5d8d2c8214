#include "step/stages.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "model/motion.h"
#include "scene/actions/actions.h"
#include "scene/collapse_load.h"
#include "scene/driven.h"
#include "step/actions/actions.h"
#include "step/block_motion.h"
#include "step/borders.h"
#include "step/controls.h"
#include "step/gather.h"
#include "step/large_motion_run.h"
#include "step/law_swap.h"
#include "step/measure.h"
#include "step/promotion.h"
#include "step/set_up.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Checks in a row that must pass: at one of them a vibration may be at its turning point.
constexpr int kCalmChecks = 5;
constexpr long kDefaultRows = 1000;   // rows of a stage with record_interval 0
constexpr long kHalfCycleRows = 200;  // rows of a half cycle with record_interval 0
// Seconds between rows under ground motion, at most. Maxima are those of rows: of a vibration with a period of 0.06 s
// rows miss 0.5 %, longer steps the square of it more.
constexpr double kGroundRow = 2e-3;
constexpr long kUnknownLength = 200;  // steps between rows of a stage whose length cannot be foreseen

long chosen_record_interval(const Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  if (settings.record_interval > 0) return settings.record_interval;
  if (s.scene.output.record_interval > 0.0)
    return std::max(1L, std::lround(s.scene.output.record_interval / s.data.time_step));
  double steps = std::numeric_limits<double>::infinity();
  if (settings.duration) steps = *settings.duration / s.data.time_step;
  if (settings.displacement) {
    const double speed = std::abs(driven_velocity(settings));
    if (speed > 0.0)
      steps = std::min(steps, (*settings.displacement / speed + 0.5 * settings.ramp_time) / s.data.time_step);
  }
  if (const auto growth = settings.collapse ? seconds_of_growth(*settings.collapse) : std::nullopt)
    steps = std::min(steps, (settings.ramp_time + *growth) / s.data.time_step);
  const double of_ground = settings.ground ? kGroundRow / s.data.time_step : std::numeric_limits<double>::infinity();
  if (!std::isfinite(std::min(steps, of_ground))) return kUnknownLength;
  const long rows =
      s.controls.cycles ? std::max(kDefaultRows, kHalfCycleRows * s.controls.cycles->half_cycles()) : kDefaultRows;
  return std::max(1L, std::lround(std::min(steps / static_cast<double>(rows), of_ground)));
}

}  // namespace

double time_now(const Simulation::Impl& s) {
  if (s.large_motion) return s.large_motion->stepping.time;
  return s.progress.clock_start + static_cast<double>(s.progress.step - s.progress.clock_start_step) * s.data.time_step;
}

double stage_time(const Simulation::Impl& s) {
  return s.large_motion ? s.large_motion->stepping.time - s.progress.stage_start
                        : static_cast<double>(s.progress.stage_step) * s.data.time_step;
}

void begin_stage(Simulation::Impl& s, int index) {
  const Stage& settings = s.scene.stages[static_cast<std::size_t>(index)];
  if (const std::string beyond = leaves_lattice(s.scene, static_cast<std::size_t>(index));
      !s.large_motion && !beyond.empty()) {
    gather(s, Part::all);
    promote(s, fmt::format("stage '{}' {}", settings.name, beyond), index);
  }
  gather(s, Part::row);
  const bool swaps_laws = !settings.law_swaps.empty();
  if (!s.parts.divided || (s.large_motion && swaps_laws))
    gather(s, Part::all);
  else if ((settings.whiffletree || !settings.roof.empty() || settings.ground) && !s.large_motion)
    gather(s, Part::all, Who::holders);
  else if (swaps_laws)
    receive_whole_borders(s);
  const Stage* const previous = index > 0 ? &s.scene.stages[static_cast<std::size_t>(index) - 1] : nullptr;
  if (s.large_motion && s.parts.divided) exchange_blocks_of_stage(s, settings, previous);
  if (s.large_motion)
    begin_large_motion_stage(s, settings, previous);
  else
    control_bricks(s, settings, previous);
  if (!s.large_motion) s.progress.stage_start = time_now(s);
  // With the body force of a collapse, which fades over the ramp.
  s.controls.gravity_from =
      previous && previous->collapse ? geometry::array(s.large_motion->actions.gravity) : s.data.gravity;
  s.actions.collapse_left = s.large_motion ? s.large_motion->actions.of_collapse : geometry::Vector{};
  s.controls.gravity_to = settings.gravity;
  s.controls.settled = false;
  s.progress.stage = index;
  s.progress.stage_step = 0;
  s.progress.in_stage = true;
  if (!s.large_motion && settings.solver) {
    const double added = s.energy.wanted ? added_kinetic_energy(s) : 0.0;
    follow_solver(s);
    if (s.energy.wanted) s.energy.lost_at_changes += added - added_kinetic_energy(s);
  }
  bind_controls(s);
  bind_floors(s);
  choose_damping(s);
  if (!s.controls.floors.empty()) s.monitor.start = {};
  for (const std::vector<int>& floor : s.controls.floors)
    s.monitor.start += displacement_at_forces(s, floor) / static_cast<double>(s.controls.floors.size());
  begin_pull(s, previous);
  s.progress.calm_checks = 0;
  // The last frame of the stage before shows the beginning of this one.
  s.progress.next_frame = index > 0 && s.scene.frames_in(static_cast<std::size_t>(index) - 1) > 0 ? 1 : 0;
  s.progress.next_row = 0;
  s.damage.frames = 0;
  s.small_motion.next_check = s.progress.step;  // controls of blocks are new
  s.progress.force_loss = {};
  s.watch.pending = false;  // sudden changes by a stage are no part of the energy balance of two steps
  s.laws.swaps.clear();
  for (const auto& [family, law] : settings.law_swaps) swap_law(s, family, law);
  s.progress.row_interval = chosen_record_interval(s);
  if (s.ranks) partition_work(s);  // monitored blocks have changed
}

void choose_damping(Simulation::Impl& s) {
  const bool settling = s.progress.stage >= 0 && current_stage(s).equilibrium_ratio;
  if (s.large_motion) s.large_motion->settle(settling);
  const Damping damping = damping_of(solver_in_use(s), settling);
  s.data.eq1 = damping.eq1, s.data.local_damping = damping.gamma, s.data.mass_damping = damping.alpha;
}

namespace {

// Checks of a half cycle, at least: their largest force is within 1e-3 of the largest one, which is near its end at
// rest.
constexpr double kChecksAHalfCycle = 100.0;

bool force_check_is_due(const Simulation::Impl& s) {
  const double steps = s.controls.cycles->shortest_half_cycle() / s.data.time_step;
  const double interval = std::clamp(steps / kChecksAHalfCycle, 1.0, static_cast<double>(kCheckInterval));
  return s.progress.stage_step % static_cast<long>(interval) == 0;
}

}  // namespace

bool force_lost(Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  if (!settings.cycles || !settings.cycles->stop_at_force_loss || !force_check_is_due(s)) return false;
  gather(s, Part::row);
  const int half_cycle = s.controls.cycles->half_cycle(stage_time(s));
  if (!s.progress.force_loss.see(measure_row(s).resistance, half_cycle, s.controls.cycles->target(half_cycle),
                                 *settings.cycles->stop_at_force_loss))
    return false;
  s.outcome.force_losses.push_back({s.progress.stage, s.progress.force_loss.half_cycle(), s.progress.force_loss.force(),
                                    s.progress.force_loss.largest()});
  return true;
}

double stage_fraction(const Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  double fraction = 0.0;
  if (settings.duration) fraction = stage_time(s) / *settings.duration;
  if (settings.collapse) {
    // The multiplier at collapse is not known: frames and progress count to the limit, which ends the stage in any
    // case.
    const Collapse& c = *settings.collapse;
    fraction = std::max(fraction, std::min(1.0 - 1e-9, (s.actions.multiplier - *c.start) / (*c.limit - *c.start)));
  }
  if (settings.displacement) {
    const auto c = static_cast<std::size_t>(settings.direction);
    const double moved = displacement_now(s, shown_blocks(s))[c] - s.monitor.start[c];
    // Motion against the velocity of the stage, which a ramp after a stage to the other side begins with, counts less
    // than none.
    const double driven = driven_velocity(settings),
                 way = driven == 0.0 ? std::abs(moved) : std::copysign(1.0, driven) * moved;
    fraction = std::max(fraction, way / *settings.displacement);
  }
  return fraction;
}

bool equilibrium_reached(Simulation::Impl& s, const Stage& settings) {
  if (!settings.equilibrium_ratio) return false;
  const bool ramped = stage_time(s) >= settings.ramp_time;
  s.progress.calm_checks =
      ramped && s.progress.unbalanced_ratio <= *settings.equilibrium_ratio ? s.progress.calm_checks + 1 : 0;
  return is_calm(s);
}

bool is_calm(const Simulation::Impl& s) { return s.progress.calm_checks >= kCalmChecks; }

void swap_law(Simulation::Impl& s, const std::string& name, const std::string& law) {
  const auto& families = s.model.assembly.families;
  const auto found = std::find_if(families.begin(), families.end(), [&](const auto& f) { return f.name == name; });
  if (found == families.end()) {
    throw Error(Exit::bad_input, fmt::format("stage '{}' swaps the law of joint family '{}', which does not exist",
                                             current_stage(s).name, name));
  }
  refuse_swap_of_strips(s.scene, name, current_stage(s).source.text);
  if (const std::string fault = fault_of_law_swap(*found, current_stage(s)); !fault.empty())
    throw Error(Exit::bad_input, fault);
  const auto f = static_cast<std::size_t>(found - families.begin());
  auto material = successor(*found, law);
  if (s.large_motion)
    swap_law_in_large_motion(s, f, std::move(material));
  else
    swap_lattice_law(s, f, std::move(material));
  if (s.energy.wanted) s.energy.lost_at_changes -= s.laws.swaps.back().energy_jump;
}

}  // namespace quoin
