// Smooth growth of velocities and forces over a ramp.
#pragma once

#include <algorithm>

namespace quoin {

// 10 t^3 - 15 t^4 + 6 t^5: from 0 to 1 with zero rate and acceleration at both ends.
inline double smooth_step(double t) {
  return t <= 0.0 ? 0.0 : t >= 1.0 ? 1.0 : t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

// Integral over time of smooth_step(time / ramp): displacement at a velocity that grows to 1 over the ramp.
inline double smooth_way(double time, double ramp) {
  if (ramp <= 0.0) return time;
  const double t = std::min(1.0, time / ramp);
  return ramp * t * t * t * t * (2.5 + t * (-3.0 + t)) + std::max(0.0, time - ramp);
}

// Displacement since the begin of a ramp over which a velocity changes from one value to another.
inline double way_between(double from, double to, double time, double ramp) {
  return from * time + (to - from) * smooth_way(time, ramp);
}

}  // namespace quoin
