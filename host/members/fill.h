// Soil on a face: its force at one point. Equations: README.md.
#pragma once

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

struct FillLaw {
  Vector up, out;                                     // unit: upwards in the soil; level part of the face's normal
  double upright = 0.0, level = 0.0;                  // area of the face seen from above and from the side, m2
  double vertical = 0.0;                              // vertical stress of the soil at the point, Pa
  double at_rest = 0.0, active = 0.0, passive = 0.0;  // horizontal over vertical stress
  double stiffness = 0.0;                             // Pa/m
};

// Energies in J.
struct FillState {
  double pressure = 0.0;  // horizontal, Pa
  double slid = 0.0;      // plastic displacement into the soil, m
  double jack = 0.0;      // displacement that preloads the soil to its pressure at rest, m
  Vector force;           // force on the block, N
  Vector moved;           // displacement of the point since the start, m
  double stored = 0.0, dissipated = 0.0, outside = 0.0;

  // Updates the state. share: share of the soil's weight that acts; now: displacement of the point since the start, m.
  void follow(const FillLaw& law, double share, const Vector& now);
};

}  // namespace quoin::members
