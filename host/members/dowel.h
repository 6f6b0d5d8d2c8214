// A bar across a joint: elastic-plastic along its axis and in shear. Equations: README.md.
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
  double drawn = 0.0;  // plastic elongation, m
  Vector slid;         // plastic slip across the bar, m
  double force = 0.0;  // N, tension positive
  Vector shear;        // force on the first block, N
  double stored = 0.0, dissipated = 0.0;

  // Updates the state. along: unit vector of the bar; apart: motion of the second block relative to the first, m; both
  // in the frame of the first block.
  void follow(const DowelLaw& law, const Vector& along, const Vector& apart);
};

}  // namespace quoin::members
