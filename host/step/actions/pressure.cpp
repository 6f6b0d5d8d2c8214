// Pressures on faces of blocks: those that act at the end of the stage before fade while those of this one grow.
#include "scene/load_place.h"
#include "step/actions/action.h"
#include "step/actions/fading.h"
#include "step/state.h"

namespace quoin {

namespace {

void add_pressures(Simulation::Impl& s, const Stage& settings) {
  blocks::Model& m = *s.large_motion;
  for (const FacePressure& pressure : settings.pressures) {
    for (const blocks::BlockFace& face :
         blocks::outer_faces(m.assembly, pressure.block, geometry::vector(pressure.normal), settings.source.text)) {
      blocks::Pressure added{};
      added.block = face.block, added.face = face.face, added.value = pressure.pressure;
      m.add(added);
    }
  }
}

void bind_pressures(Simulation::Impl& s, const Stage& settings, const Stage*) {
  s.actions.fading_pressures = keep_acting(*s.large_motion, s.large_motion->actions.pressures,
                                           [](blocks::Pressure& pressure) { pressure.value *= pressure.scale; });
  add_pressures(s, settings);
}

void scale_pressures(Simulation::Impl& s, const Stage&, double ramp) {
  auto& pressures = s.large_motion->actions.pressures;
  for (std::size_t i = 0; i < pressures.size(); ++i)
    pressures[i].scale = i < s.actions.fading_pressures ? 1.0 - ramp : ramp;
}

}  // namespace

extern const Action kPressure{.names =
                                  [](const Stage& stage, const VisitName& visit) {
                                    for (const FacePressure& pressure : stage.pressures) visit(pressure.block);
                                  },
                              .bind = bind_pressures,
                              .apply = scale_pressures,
                              .saved = kSaved<&Actions::fading_pressures>};

}  // namespace quoin
