// Pressures on faces of blocks: those of the stage before fade while those of this one grow.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "scene/generate_blocks.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

void Simulation::Impl::add_pressures(const Stage& settings) {
  blocks::Model& m = *large_motion;
  const auto& assembly = m.assembly;
  for (const FacePressure& pressure : settings.pressures) {
    blocks::Pressure added{};
    added.block = blocks_named(pressure.block, settings.source.text).front(), added.value = pressure.pressure;
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

void Simulation::Impl::bind_pressures(const Stage& settings, const Stage* previous) {
  if (previous) add_pressures(*previous);
  fading_pressures = large_motion->actions.pressures.size();
  add_pressures(settings);
}

void Simulation::Impl::scale_pressures(const Stage&, double s) {
  auto& pressures = large_motion->actions.pressures;
  for (std::size_t i = 0; i < pressures.size(); ++i) pressures[i].scale = i < fading_pressures ? 1.0 - s : s;
}

}  // namespace quoin
