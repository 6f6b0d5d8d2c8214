// Forces at points of blocks: those that act at the end of the stage before fade while those of this one grow. A moving
// load is a force at each of its positions: neighbouring positions share it by linear interpolation.
#include <algorithm>
#include <cmath>

#include "scene/load_place.h"
#include "step/actions/action.h"
#include "step/actions/fading.h"
#include "step/state.h"

namespace quoin {

namespace {

void add_forces(Simulation::Impl& s, const Stage& settings) {
  blocks::Model& m = *s.large_motion;
  for (const PointForce& given : settings.forces) {
    blocks::Load added{};
    added.force = geometry::vector(given.force);
    added.point = geometry::vector(given.point);
    added.block = blocks::block_at(m.assembly, given.block, added.point, settings.source.text);
    m.add(added);
  }
  if (!settings.moving_load) return;
  for (const blocks::LoadPlace& place : blocks::places_of(*settings.moving_load, m.assembly, settings.source.text)) {
    blocks::Load added{};
    added.block = place.block, added.point = place.at;
    added.force = geometry::vector(settings.moving_load->force);
    m.add(added);
  }
}

// Share of a moving load at position k of n. way: share of its line that it has moved, 0 to 1.
double share_at(std::size_t k, std::size_t n, double way) {
  if (n == 1) return 1.0;
  return std::max(0.0, 1.0 - std::abs(way * static_cast<double>(n - 1) - static_cast<double>(k)));
}

void bind_forces(Simulation::Impl& s, const Stage& settings, const Stage*) {
  s.actions.fading_loads = keep_acting(*s.large_motion, s.large_motion->actions.loads,
                                       [](blocks::Load& load) { load.force = load.scale * load.force; });
  add_forces(s, settings);
}

void scale_forces(Simulation::Impl& s, const Stage& settings, double ramp) {
  auto& loads = s.large_motion->actions.loads;
  for (std::size_t i = 0; i < loads.size(); ++i) loads[i].scale = i < s.actions.fading_loads ? 1.0 - ramp : ramp;
  // The positions of a moving load are the last loads.
  if (!settings.moving_load) return;
  const double moves = *settings.duration - settings.ramp_time;
  const double gone = s.large_motion->stepping.time - s.progress.stage_start - settings.ramp_time;
  const double way = std::clamp(gone / moves, 0.0, 1.0);
  const auto n = static_cast<std::size_t>(settings.moving_load->positions);
  for (std::size_t k = 0; k < n; ++k) loads[loads.size() - n + k].scale *= share_at(k, n, way);
}

}  // namespace

extern const Action kForce{.names =
                               [](const Stage& stage, const VisitName& visit) {
                                 for (const PointForce& force : stage.forces) visit(force.block);
                               },
                           .bind = bind_forces,
                           .apply = scale_forces,
                           .saved = kSaved<&Actions::fading_loads>};

}  // namespace quoin
