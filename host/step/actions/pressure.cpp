// Pressures on faces of blocks: those of the stage before fade while those of this one grow.
#include "step/actions/action.h"
#include "step/large_motion_run.h"
#include "step/state.h"

namespace quoin {

namespace {

void add_pressures(Simulation::Impl& s, const Stage& settings) {
  blocks::Model& m = *s.large_motion;
  const auto& assembly = m.assembly;
  for (const FacePressure& pressure : settings.pressures) {
    blocks::Pressure added{};
    added.block = blocks_named(s, pressure.block, settings.source.text).front(), added.value = pressure.pressure;
    const blocks::Block& block = assembly.blocks[static_cast<std::size_t>(added.block)];
    const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
    const geometry::Matrix turned = matrix(block.orientation);
    const auto towards = [&](std::size_t face) {
      return dot(turned * shape.normals[face], geometry::vector(pressure.normal));
    };
    for (std::size_t f = 1; f < shape.faces.size(); ++f) {
      if (towards(f) > towards(static_cast<std::size_t>(added.face))) added.face = static_cast<int>(f);
    }
    m.add(added);
  }
}

void bind_pressures(Simulation::Impl& s, const Stage& settings, const Stage* previous) {
  if (previous) add_pressures(s, *previous);
  s.actions.fading_pressures = s.large_motion->actions.pressures.size();
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
