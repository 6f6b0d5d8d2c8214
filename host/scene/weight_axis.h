// The vertical of a scene.
#pragma once

#include <algorithm>

#include "base/upright_axis.h"
#include "scene/scene.h"

namespace quoin {

// Axis of the weight of a scene: 0, 1 or 2 for x, y or z; y without weight.
inline int upright_axis(const Scene& scene) {
  const auto weighed = std::ranges::find_if(scene.stages, [](const Stage& stage) { return stage.gravity != Vec3{}; });
  return upright_axis(weighed != scene.stages.end() ? weighed->gravity : Vec3{});
}

}  // namespace quoin
