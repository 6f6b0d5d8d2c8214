#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/smooth_step.h"
#include "step/actions/action.h"
#include "step/actions/actions.h"
#include "step/block_motion.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

// Travel of a jack's head at which a push ends, as a multiple of displacement + peak force / stiffness.
constexpr double kLostTravel = 5.0;

void bind_floors(Simulation::Impl& s) {
  s.controls.floors.clear();
  if (s.progress.stage < 0) return;
  const Stage& settings = current_stage(s);
  std::vector<std::vector<std::string>> floors;
  if (settings.whiffletree)
    floors = settings.whiffletree->floors;
  else if (!settings.roof.empty())
    floors = {settings.roof};
  for (const auto& floor : floors) {
    std::vector<int>& blocks = s.controls.floors.emplace_back();
    for (const std::string& name : floor) {
      const std::vector<int> named = blocks_named(s, name, settings.source.text);
      if (named.empty()) {
        throw Error(Exit::bad_input, fmt::format("{}: stage '{}' has the floor '{}', but the assembly has no block of "
                                                 "that name",
                                                 settings.source.text, settings.name, name));
      }
      blocks.insert(blocks.end(), named.begin(), named.end());
    }
  }
}

void begin_pull(Simulation::Impl& s, const Stage* previous) {
  const Stage& settings = current_stage(s);
  if (!settings.whiffletree) return;
  const Whiffletree* const before = previous && previous->whiffletree ? &*previous->whiffletree : nullptr;
  JackHead& jack = s.controls.jack;
  jack.from = s.monitor.start[0] + (before ? jack.force / settings.whiffletree->stiffness : 0.0);
  jack.velocity_from = before && !previous->cycles ? before->velocity : 0.0;  // cycles end at rest
  jack.travel = jack.peak = 0.0;
}

void pull_whiffletree(Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  const Whiffletree& tree = *settings.whiffletree;
  JackHead& jack = s.controls.jack;
  const double time = stage_time(s), before = jack.velocity_from;
  jack.travel = s.controls.cycles ? s.controls.cycles->position(time, before)
                                  : way_between(before, tree.velocity, time, settings.ramp_time);
  // Current displacements, as for joints: a spring with those of a step before would add energy in every step.
  double mean = 0.0;
  for (const std::vector<int>& floor : s.controls.floors)
    mean += displacement_now(s, floor)[0] / static_cast<double>(s.controls.floors.size());
  jack.force = tree.stiffness * (jack.from + jack.travel - mean);
  jack.peak = std::max(jack.peak, std::abs(jack.force));
  for (const std::vector<int>& floor : s.controls.floors) {
    for (const int block : floor) pull_block(s, block, jack.force / static_cast<double>(floor.size()));
  }
}

// u = mean of the floors + F / stiffness. Where all floors move as the roof, u is at most displacement + peak force /
// stiffness at its arrival. Floors that go on without the roof take it to a multiple of that.
bool push_lost(Simulation::Impl& s, std::vector<Warning>* warnings) {
  const Stage& settings = current_stage(s);
  if (!settings.whiffletree || settings.cycles || !settings.displacement) return false;
  const Whiffletree& tree = *settings.whiffletree;
  const JackHead& jack = s.controls.jack;
  const double way = std::copysign(1.0, tree.velocity) * jack.travel;
  if (way <= kLostTravel * (*settings.displacement + jack.peak / tree.stiffness)) return false;
  std::string floors;
  for (std::size_t f = 0; f < tree.floors.size(); ++f)
    floors += fmt::format("{}'{}' {:.3g} mm", f > 0 ? ", " : "", tree.floors[f].front(),
                          1e3 * displacement_now(s, s.controls.floors[f])[0]);
  warn_once(
      s, "push_lost",
      fmt::format(
          "stage '{}' ends before its displacement of {:g} mm: the whiffletree has gone {:.3g} mm, more "
          "than {:g} times this displacement and what its stiffness of {:g} N/m takes at the largest "
          "force on a floor, {:.4g} kN. Floors go on without the roof, as where their beams work loose. Means since "
          "the start, each floor by its first beam: {}. Results up to here are kept; tie or load the "
          "beams of the floor that has gone on, leave it out, or give a smaller displacement",
          settings.name, 1e3 * *settings.displacement, 1e3 * way, kLostTravel, tree.stiffness, 1e-3 * jack.peak,
          floors),
      warnings);
  return true;
}

// Forces are applied by pull_whiffletree, for both kinds of motion.
extern const Action kWhiffletree{.names = [](const Stage& stage, const VisitName& visit) {
  std::for_each(stage.roof.begin(), stage.roof.end(), visit);
  if (!stage.whiffletree) return;
  for (const auto& floor : stage.whiffletree->floors) std::for_each(floor.begin(), floor.end(), visit);
}};

}  // namespace quoin
