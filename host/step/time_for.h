// How long a block takes for a way, as checks of motion reckon.
#pragma once

#include <cmath>

#include "step/unjoined_blocks.h"

namespace quoin {

// Until a way, m, is gone at this speed, m/s, if it grows by UnjoinedBlocks::kAcceleration meanwhile, s.
inline double time_for(double way, double speed) {
  const double a = UnjoinedBlocks::kAcceleration;
  return 2.0 * way / (speed + std::sqrt(speed * speed + 2.0 * a * way));
}

}  // namespace quoin
