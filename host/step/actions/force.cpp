// Forces at points of blocks: those of the stage before fade while those of this one grow.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "scene/generate_blocks.h"
#include "step/actions/action.h"

namespace quoin {

using geometry::Vector;

void Simulation::Impl::add_forces(const Stage& settings) {
  blocks::Model& m = *large_motion;
  for (const PointForce& given : settings.forces) {
    blocks::Load added{};
    added.block = blocks_named(given.block, settings.source.text).front();
    added.force = geometry::vector(given.force);
    added.point = geometry::vector(given.point);
    m.add(added);
  }
}

void Simulation::Impl::bind_forces(const Stage& settings, const Stage* previous) {
  if (previous) add_forces(*previous);
  fading_loads = large_motion->loads().size();
  add_forces(settings);
}

void Simulation::Impl::scale_forces(const Stage&, double s) {
  auto& loads = large_motion->loads();
  for (std::size_t i = 0; i < loads.size(); ++i) loads[i].scale = i < fading_loads ? 1.0 - s : s;
}

}  // namespace quoin
