#include "step/actions/whiffletree.h"

#include <fmt/core.h>

#include <algorithm>

#include "base/error.h"
#include "base/smooth_step.h"
#include "step/actions/action.h"
#include "step/actions/drive.h"
#include "step/large_motion_run.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/watched_motion.h"

namespace quoin {

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
    WatchedBlocks& blocks = s.controls.floors.emplace_back();
    for (const std::string& name : floor) {
      if (s.large_motion) {
        const std::vector<int> named = blocks_named(s, name, settings.source.text);
        blocks.large_motion.insert(blocks.large_motion.end(), named.begin(), named.end());
      } else if (!add_named(s, name, blocks)) {
        throw Error(Exit::bad_input, fmt::format("{}: stage '{}' has the floor '{}', but the assembly has no block of "
                                                 "that name",
                                                 settings.source.text, settings.name, name));
      }
    }
  }
}

void pull_whiffletree(Simulation::Impl& s) {
  const Stage& settings = current_stage(s);
  const Whiffletree& tree = *settings.whiffletree;
  const double moved = s.controls.cycles ? s.controls.cycles->position(stage_time(s))
                                         : tree.velocity * smooth_way(stage_time(s), settings.ramp_time);
  // Current displacements, as for joints: a spring with those of a step before would add energy in every step.
  double mean = 0.0;
  for (const WatchedBlocks& floor : s.controls.floors)
    mean += displacement_now(s, floor)[0] / static_cast<double>(s.controls.floors.size());
  const double pull = tree.stiffness * (s.monitor.start[0] + moved - mean);
  for (const WatchedBlocks& floor : s.controls.floors) {
    for (const int block : floor.large_motion) pull_block(s, block, pull / floor.count());
    for (const int body : floor.bodies) {
      const auto [lanes, lane] = s.lattice.place[static_cast<std::size_t>(body)];
      s.lattice.bodies[static_cast<std::size_t>(lanes)].applied_force[0][lane] = pull / floor.count();
    }
    for (const int i : floor.loaded) {
      s.controls.load_ramps[static_cast<std::size_t>(i)].now[0] = pull / floor.count();
      s.controls.apply_load(s.model, static_cast<std::size_t>(i));
    }
  }
}

// Forces are applied by pull_whiffletree, for both kinds of motion.
extern const Action kWhiffletree{.names = [](const Stage& stage, const VisitName& visit) {
  std::for_each(stage.roof.begin(), stage.roof.end(), visit);
  if (!stage.whiffletree) return;
  for (const auto& floor : stage.whiffletree->floors) std::for_each(floor.begin(), floor.end(), visit);
}};

}  // namespace quoin
