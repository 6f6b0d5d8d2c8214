// Loads of earlier stages, which fade.
#pragma once

#include <cstddef>
#include <vector>

#include "step/large_motion.h"

namespace quoin {

// Keeps those loads that act now, at their current values: the stage may have ended inside of its ramp. take_scale:
// multiplies a load by its scale. Returns their number.
template <class Load, class TakeScale>
std::size_t keep_acting(blocks::Model& m, std::vector<Load>& loads, const TakeScale& take_scale) {
  std::erase_if(loads, [](const Load& load) { return load.scale == 0.0; });
  for (Load& load : loads) {
    take_scale(load);
    m.actions.loaded[static_cast<std::size_t>(load.block)] = 1;
  }
  return loads.size();
}

}  // namespace quoin
