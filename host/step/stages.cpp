// A stage of the loading: how it begins, how far it has come, when it has ended.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/collapse_load.h"
#include "scene/leaves_lattice.h"
#include "step/law_swap.h"
#include "step/state.h"

namespace quoin {

namespace {

constexpr int kCalmChecks = 5;        // looks in a row that must pass: one may catch a swing at its turning point
constexpr long kDefaultRows = 1000;   // rows of a stage with record_interval 0
constexpr long kHalfCycleRows = 200;  // rows of a half cycle with record_interval 0
constexpr long kUnknownLength = 200;  // steps between rows of a stage whose length cannot be foreseen

}  // namespace

void Simulation::Impl::begin_stage(int index) {
  const Stage& settings = scene.stages[static_cast<std::size_t>(index)];
  if (const std::string beyond = leaves_lattice(scene, static_cast<std::size_t>(index));
      !large_motion && !beyond.empty()) {
    gather(Part::all);
    promote(fmt::format("stage '{}' {}", settings.name, beyond));
  }
  if (large_motion && !left && settings.solver && settings.solver->implicit_contacts)
    throw Error(
        Exit::bad_input,
        fmt::format("{}: stage '{}': solver.implicit_contacts is for blocks on the lattice, and this scene runs in "
                    "the general kernels; remove it from the stage",
                    settings.source.text, settings.name));
  gather(Part::row);
  const bool swaps_laws = !settings.law_swaps.empty();
  if (!in_parts || (large_motion && swaps_laws))
    gather(Part::all);
  else if (settings.whiffletree && !large_motion)
    gather(Part::all, Who::holders);
  else if (swaps_laws)
    receive_whole_borders();
  const Stage* const previous = index > 0 ? &scene.stages[static_cast<std::size_t>(index) - 1] : nullptr;
  if (large_motion && in_parts) exchange_blocks_of_stage(settings, previous);
  if (large_motion)
    begin_large_motion_stage(settings, previous);
  else
    control_bodies(settings, previous);
  if (!large_motion) stage_start_time = now();
  gravity_from = data.gravity;
  gravity_to = settings.gravity;
  controls_settled = false;
  stage = index;
  stage_step = 0;
  in_stage = true;
  if (!large_motion && settings.solver) {
    const double added = want_energy ? added_kinetic_energy() : 0.0;
    follow_solver();
    if (want_energy) energy_inertia += added - added_kinetic_energy();
  }
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
  // The end of the stage before shows how this one begins.
  next_frame = index > 0 && scene.frames_in(static_cast<std::size_t>(index) - 1) > 0 ? 1 : 0;
  next_row = 0;
  next_motion_check = step_count;  // what drives blocks is new
  force_loss = {};
  watch.pending = false;  // what a stage changes at once is in no balance of steps
  swaps.clear();
  row_interval = chosen_record_interval();
  for (const auto& [family, law] : settings.law_swaps) swap_law(family, law);
  if (ranks) partition_work();  // others are watched now
}

void Simulation::Impl::choose_damping() {
  const bool settling = stage >= 0 && scene.stages[static_cast<std::size_t>(stage)].equilibrium_ratio;
  const SolverSettings& settings = large_motion ? scene.solver : solver_in_use();
  if (large_motion) large_motion->is_settling = settling;
  data.local_damping = settling ? settings.settling_damping.value_or(settings.local_damping) : settings.local_damping;
}

bool Simulation::Impl::force_lost() {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  if (!settings.cycles || !settings.cycles->stop_at_force_loss || stage_step % kCheckInterval != 0) return false;
  gather(Part::row);
  const int half_cycle = cycles->half_cycle(stage_time());
  if (!force_loss.see(measure().resistance, half_cycle, cycles->target(half_cycle),
                      *settings.cycles->stop_at_force_loss))
    return false;
  outcome.force_losses.push_back({stage, force_loss.half_cycle(), force_loss.force(), force_loss.largest()});
  return true;
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
      if (!settings.whiffletree && !monitor_blocks.empty() && drive.block == monitor_blocks.front())
        speed = std::abs(drive.velocity_to[settings.direction]);
    }
    if (speed > 0.0)
      steps = std::min(steps, (*settings.displacement / speed + 0.5 * settings.ramp_time) / data.time_step);
  }
  if (const auto growth = settings.collapse ? seconds_of_growth(*settings.collapse) : std::nullopt)
    steps = std::min(steps, (settings.ramp_time + *growth) / data.time_step);
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
    fraction = std::max(fraction, std::min(1.0 - 1e-9, (multiplier - *c.start) / (*c.limit - *c.start)));
  }
  if (settings.displacement && large_motion) {
    const auto c = static_cast<std::size_t>(settings.direction);
    fraction = std::max(fraction, std::abs((whiffletree.empty() ? block_translation(monitor_blocks)[c]
                                                                : floor_displacement_now(whiffletree.size() - 1)) -
                                           monitor_start[c]) /
                                      *settings.displacement);
  } else if (settings.displacement) {
    const auto c = static_cast<std::size_t>(settings.direction);
    double now = whiffletree.empty() ? mean_of(monitor, &BodyLanes::displacement)[c]
                                     : floor_displacement(whiffletree.size() - 1);
    for (const int i : monitor_loaded) now += displacement_of_loaded(i)[c] / static_cast<double>(monitor_loaded.size());
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
  if (large_motion) return swap_law_in_large_motion(f, std::move(material));
  swap_lattice_law(f, std::move(material));
}

}  // namespace quoin
