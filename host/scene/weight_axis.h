// The weight of a scene, and its vertical.
#pragma once

#include <algorithm>

#include "base/upright_axis.h"
#include "scene/scene.h"

namespace quoin {

// Gravity of the first stage that has weight, m/s2; 0: none has.
inline Vec3 first_gravity(const Scene& scene) {
  const auto weighed = std::ranges::find_if(scene.stages, [](const Stage& stage) { return stage.gravity != Vec3{}; });
  return weighed != scene.stages.end() ? weighed->gravity : Vec3{};
}

// Axis of the weight of a scene: 0, 1 or 2 for x, y or z; y without weight.
inline int upright_axis(const Scene& scene) { return upright_axis(first_gravity(scene)); }

}  // namespace quoin
