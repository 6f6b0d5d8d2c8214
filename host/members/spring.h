// Bedding of a face on the ground: spring and dashpot at one point of it. Equations: README.md.
#pragma once

#include <cstdint>
#include <limits>

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

// Law for the area of one point.
struct SpringLaw {
  double normal = 0.0, shear = 0.0;                           // N/m
  double normal_dashpot = 0.0, shear_dashpot = 0.0;           // N s/m
  double friction = std::numeric_limits<double>::infinity();  // largest shear over normal force
  std::uint64_t tension = 0;                                  // 1: it takes tension
};

// Energies in J.
struct SpringState {
  Vector moved;  // displacement of the point relative to the ground since the start, m
  Vector slid;   // slip along the face, a part of `moved`, m
  Vector force;  // force on the block, N
  double stored = 0.0, dissipated = 0.0;

  // Updates the state. out: outward normal of the block at the start, unit. now: displacement of the point relative to
  // the ground since the start, m. dt: time since the last call, s.
  void follow(const SpringLaw& law, const Vector& out, const Vector& now, double dt);
};

}  // namespace quoin::members
