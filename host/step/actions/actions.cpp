#include "step/actions/actions.h"

#include <algorithm>
#include <functional>

#include "base/registry.h"
#include "scene/load_place.h"
#include "step/actions/action.h"
#include "step/block_motion.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

// In the order of their application.
QUOIN_REGISTRY(Action, kActions, kDrive, kGround, kForce, kPressure, kGravity, kMembers, kCollapse, kWhiffletree);

std::vector<int> blocks_named_in(const Simulation::Impl& s, const Stage& settings) {
  std::vector<int> blocks;
  for (const Action& action : kActions) {
    if (!action.names) continue;
    action.names(settings, [&](const std::string& name) {
      const std::vector<int> named = blocks_named(s, name, settings.source.text);
      blocks.insert(blocks.end(), named.begin(), named.end());
    });
  }
  if (settings.moving_load) {
    for (const blocks::LoadPlace& place :
         blocks::places_of(*settings.moving_load, s.large_motion->assembly, settings.source.text))
      blocks.push_back(place.block);
  }
  return blocks;
}

void bind_actions(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  for (const Action& action : kActions) {
    if (action.bind && (s.large_motion || action.on_lattice)) action.bind(s, settings, previous);
  }
}

void save_actions(ArchiveWriter& to, const Simulation::Impl& s) {
  for (const Action& action : kActions) {
    if (action.saved.save) action.saved.save(to, s.actions);
  }
}

void restore_actions(ArchiveReader& from, Simulation::Impl& s) {
  for (const Action& action : kActions) {
    if (action.saved.restore) action.saved.restore(from, s.actions);
  }
}

void apply_actions(Simulation::Impl& s, double ramp) {
  const Stage& settings = current_stage(s);
  for (const Action& action : kActions) {
    if (action.apply && (s.large_motion || action.on_lattice)) action.apply(s, settings, ramp);
  }
}

}  // namespace quoin
