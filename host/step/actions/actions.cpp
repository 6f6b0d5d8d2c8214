#include "step/actions/actions.h"

#include <algorithm>
#include <functional>

#include "scene/load_place.h"
#include "step/actions/action.h"
#include "step/large_motion_run.h"
#include "step/stages.h"
#include "step/state.h"

namespace quoin {

namespace {

using Visit = std::function<void(const std::string&)>;

void driven(const Stage& stage, const Visit& visit) {
  for (const BodyControl& control : stage.controls) visit(control.body);
}
void pushed(const Stage& stage, const Visit& visit) {
  for (const PointForce& force : stage.forces) visit(force.block);
}
void pressed(const Stage& stage, const Visit& visit) {
  for (const FacePressure& pressure : stage.pressures) visit(pressure.block);
}
void of_supports(const Stage& stage, const Visit& visit) {
  if (!stage.ground) return;
  for (const GroundMotion& support : stage.ground->supports)
    std::for_each(support.blocks.begin(), support.blocks.end(), visit);
}
void of_floors(const Stage& stage, const Visit& visit) {
  if (!stage.whiffletree) return;
  for (const auto& floor : stage.whiffletree->floors) std::for_each(floor.begin(), floor.end(), visit);
}

// In the order in which they act.
constexpr Action kActions[] = {
    {"drive", driven, bind_drives, drive_blocks},
    {"ground", of_supports, bind_ground, follow_ground},
    {"force", pushed, bind_forces, scale_forces},
    {"pressure", pressed, bind_pressures, scale_pressures},
    {"gravity", nullptr, nullptr, apply_gravity},
    {"members", nullptr, nullptr, jack_members},
    {"collapse", nullptr, bind_collapse, apply_collapse},
    {"whiffletree", of_floors, nullptr, nullptr},  // on the lattice too: see pull_whiffletree
};

}  // namespace

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
    if (action.bind) action.bind(s, settings, previous);
  }
}

void apply_actions(Simulation::Impl& s, double ramp) {
  const Stage& settings = current_stage(s);
  for (const Action& action : kActions) {
    if (action.apply) action.apply(s, settings, ramp);
  }
}

}  // namespace quoin
