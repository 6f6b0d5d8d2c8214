// Bedding of a face on the ground: what a spring and a dashpot do at one point of it. Equations: README.md.
#pragma once

#include <limits>

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

// Law of the area that a point stands for.
struct SpringLaw {
  double normal = 0.0, shear = 0.0;                           // N/m
  double normal_dashpot = 0.0, shear_dashpot = 0.0;           // N s/m
  double friction = std::numeric_limits<double>::infinity();  // largest shear over pressure
  bool tension = false;
};

// Energies in J.
struct SpringState {
  Vector moved;  // displacement of the point against the ground since the start, m
  Vector slid;   // part of `moved` that the spring has slipped along the face, m
  Vector force;  // force on the block, N
  double stored = 0.0, dissipated = 0.0;

  // out: of the block, unit, as at the start. now: where the point has moved to, on the ground. dt: since the last
  // call, s.
  void follow(const SpringLaw& law, const Vector& out, const Vector& now, double dt);
};

}  // namespace quoin::members
