// Travel time of a block, for checks of motion.
#pragma once

#include <cmath>

#include "step/unjoined_blocks.h"

namespace quoin {

// Time, s, in which a block moves by `way`, m, from this speed, m/s, at the acceleration UnjoinedBlocks::kAcceleration.
inline double time_for(double way, double speed) {
  const double a = UnjoinedBlocks::kAcceleration;
  return 2.0 * way / (speed + std::sqrt(speed * speed + 2.0 * a * way));
}

}  // namespace quoin
