// Travel time of a block, for checks of motion.
#pragma once

#include <cmath>

namespace quoin {

// Time, s, in which a block moves by `way`, m, from this speed, m/s, at this acceleration, m/s2.
inline double time_for(double way, double speed, double acceleration) {
  return 2.0 * way / (speed + std::sqrt(speed * speed + 2.0 * acceleration * way));
}

}  // namespace quoin
