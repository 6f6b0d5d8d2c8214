// Velocity at which a stage drives what it watches.
#pragma once

#include <algorithm>

#include "scene/scene.h"

namespace quoin {

// Velocity of the monitor, or of the jack of a whiffletree, along the direction of the stage after its ramp, m/s. 0:
// the stage does not drive it.
inline double driven_velocity(const Stage& stage) {
  if (stage.whiffletree) return stage.whiffletree->velocity;
  const auto c = static_cast<std::size_t>(stage.direction);
  const auto found = std::ranges::find(stage.controls, stage.monitor, &BodyControl::body);
  return found == stage.controls.end() || found->kind[c] == DofKind::free ? 0.0 : found->velocity[c];
}

}  // namespace quoin
