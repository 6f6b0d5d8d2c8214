// Damping force of equation 1 of the paper. SIMD kernels have the same in model/vectors-inl.h.
#pragma once

#include <cmath>

namespace quoin {

// gamma |F| sgn(v), N; sgn(0) = 0.
inline double local_damping(double gamma, double force, double velocity) {
  return velocity == 0.0 ? 0.0 : std::copysign(gamma * std::abs(force), velocity);
}

}  // namespace quoin
