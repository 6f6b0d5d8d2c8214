// Soil on a face: what it does at one point. Equations: README.md.
#pragma once

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

struct FillLaw {
  Vector up, out;                                     // unit: of the soil; of the face, its level part
  double upright = 0.0, level = 0.0;                  // m2: the face's area seen from above, from the side
  double vertical = 0.0;                              // stress of the soil there, Pa
  double at_rest = 0.0, active = 0.0, passive = 0.0;  // horizontal over vertical stress
  double stiffness = 0.0;                             // Pa/m
};

// Energies in J.
struct FillState {
  double pressure = 0.0;  // horizontal, Pa
  double slid = 0.0;      // plastic, into the soil, m
  double jack = 0.0;      // displacement that gives the soil its pressure at rest, m
  Vector force;           // force on the block, N
  Vector moved;           // motion in the last step, m
  double stored = 0.0, dissipated = 0.0, outside = 0.0;

  // share: of the soil that is there; now: where the point has moved to, m.
  void follow(const FillLaw& law, double share, const Vector& now);
};

}  // namespace quoin::members
