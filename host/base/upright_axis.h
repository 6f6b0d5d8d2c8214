// The axis along which weight acts.
#pragma once

#include <cmath>

#include "base/vec3.h"

namespace quoin {

// The axis that is closest to gravity: 0, 1 or 2 for x, y or z; y without gravity.
inline int upright_axis(const Vec3& gravity) {
  int upright = 1;
  for (const int c : {0, 2}) {
    if (std::abs(gravity[static_cast<std::size_t>(c)]) > std::abs(gravity[static_cast<std::size_t>(upright)]))
      upright = c;
  }
  return upright;
}

}  // namespace quoin
