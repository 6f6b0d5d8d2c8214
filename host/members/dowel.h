// A bar across a joint: elastic, then plastic, along itself and in shear. Equations: README.md.
#pragma once

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

struct DowelLaw {
  double axial = 0.0, shear = 0.0;              // N/m
  double yield_force = 0.0, yield_shear = 0.0;  // N
};

// Energies in J.
struct DowelState {
  double drawn = 0.0;  // plastic, along the bar, m
  Vector slid;         // plastic, across it, m
  double force = 0.0;  // N, tension positive
  Vector shear;        // N, on the first block
  double stored = 0.0, dissipated = 0.0;

  // along: of the bar, unit; apart: how far the second block has moved from the first, m; both in the first one's
  // frame.
  void follow(const DowelLaw& law, const Vector& along, const Vector& apart);
};

}  // namespace quoin::members
