// Forces at points and pressures on faces of blocks. Those that act at the end of the stage before fade while those of
// this one grow. A moving load is a force at each of its positions: neighbouring positions share it by linear
// interpolation.
#include <algorithm>
#include <cmath>

#include "scene/load_place.h"
#include "step/actions/action.h"
#include "step/large_motion.h"
#include "step/state.h"

namespace quoin {

namespace {

// Keeps those loads that act now, at their current values: the stage may have ended inside of its ramp. value: that of
// a load, which its scale multiplies. Returns their number.
template <class Load, class Value>
std::size_t keep_acting(blocks::Model& m, std::vector<Load>& loads, Value Load::*value) {
  std::erase_if(loads, [](const Load& load) { return load.scale == 0.0; });
  for (Load& load : loads) {
    load.*value = load.scale * (load.*value);
    m.actions.loaded[static_cast<std::size_t>(load.block)] = 1;
  }
  return loads.size();
}

// The first `fading` loads are those of earlier stages.
template <class Load>
void scale_loads(std::vector<Load>& loads, std::size_t fading, double ramp) {
  for (std::size_t i = 0; i < loads.size(); ++i) loads[i].scale = i < fading ? 1.0 - ramp : ramp;
}

void bind_forces(Simulation::Impl& s, const Stage& settings, const Stage*) {
  blocks::Model& m = *s.large_motion;
  s.actions.fading_loads = keep_acting(m, m.actions.loads, &blocks::Load::force);
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

void scale_forces(Simulation::Impl& s, const Stage& settings, double ramp) {
  auto& loads = s.large_motion->actions.loads;
  scale_loads(loads, s.actions.fading_loads, ramp);
  // The positions of a moving load are the last loads.
  if (!settings.moving_load) return;
  const double moves = *settings.duration - settings.ramp_time;
  const double gone = s.large_motion->stepping.time - s.progress.stage_start - settings.ramp_time;
  const double way = std::clamp(gone / moves, 0.0, 1.0);
  const auto n = static_cast<std::size_t>(settings.moving_load->positions);
  for (std::size_t k = 0; k < n; ++k) loads[loads.size() - n + k].scale *= share_at(k, n, way);
}

void bind_pressures(Simulation::Impl& s, const Stage& settings, const Stage*) {
  blocks::Model& m = *s.large_motion;
  s.actions.fading_pressures = keep_acting(m, m.actions.pressures, &blocks::Pressure::value);
  for (const FacePressure& pressure : settings.pressures) {
    for (const blocks::BlockFace& face :
         blocks::outer_faces(m.assembly, pressure.block, geometry::vector(pressure.normal), settings.source.text)) {
      blocks::Pressure added{};
      added.block = face.block, added.face = face.face, added.value = pressure.pressure;
      m.add(added);
    }
  }
}

}  // namespace

extern const Action kForce{.names =
                               [](const Stage& stage, const VisitName& visit) {
                                 for (const PointForce& force : stage.forces) visit(force.block);
                               },
                           .bind = bind_forces,
                           .apply = scale_forces,
                           .saved = kSaved<&Actions::fading_loads>};

extern const Action kPressure{
    .names =
        [](const Stage& stage, const VisitName& visit) {
          for (const FacePressure& pressure : stage.pressures) visit(pressure.block);
        },
    .bind = bind_pressures,
    .apply = [](Simulation::Impl& s, const Stage&,
                double ramp) { scale_loads(s.large_motion->actions.pressures, s.actions.fading_pressures, ramp); },
    .saved = kSaved<&Actions::fading_pressures>};

}  // namespace quoin
