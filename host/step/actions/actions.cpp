// The actions, and what goes over all of them.
#include "scene/load_place.h"
#include "step/actions/action.h"

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

}  // namespace

std::span<const Simulation::Impl::Action> Simulation::Impl::Action::all() {
  static constexpr Action kAll[] = {
      {"drive", driven, &Impl::bind_drives, &Impl::drive_blocks},
      {"ground", of_supports, &Impl::bind_ground, &Impl::follow_ground},
      {"force", pushed, &Impl::bind_forces, &Impl::scale_forces},
      {"pressure", pressed, &Impl::bind_pressures, &Impl::scale_pressures},
      {"gravity", nullptr, nullptr, &Impl::apply_gravity},
      {"members", nullptr, nullptr, &Impl::jack_members},
      {"collapse", nullptr, &Impl::bind_collapse, &Impl::apply_collapse},
      {"whiffletree", of_floors, nullptr, nullptr},  // on the lattice too: see pull_whiffletree
  };
  return kAll;
}

std::vector<int> Simulation::Impl::blocks_named_in(const Stage& settings) const {
  std::vector<int> blocks;
  for (const Action& action : Action::all()) {
    if (!action.names) continue;
    action.names(settings, [&](const std::string& name) {
      const std::vector<int> named = blocks_named(name, settings.source.text);
      blocks.insert(blocks.end(), named.begin(), named.end());
    });
  }
  if (settings.moving_load) {
    for (const blocks::LoadPlace& place :
         blocks::places_of(*settings.moving_load, large_motion->assembly, settings.source.text))
      blocks.push_back(place.block);
  }
  return blocks;
}

void Simulation::Impl::bind_actions(const Stage& settings, const Stage* previous) {
  for (const Action& action : Action::all()) {
    if (action.bind) (this->*action.bind)(settings, previous);
  }
}

void Simulation::Impl::apply_actions(double ramp) {
  const Stage& settings = scene.stages[static_cast<std::size_t>(stage)];
  for (const Action& action : Action::all()) {
    if (action.apply) (this->*action.apply)(settings, ramp);
  }
}

}  // namespace quoin
