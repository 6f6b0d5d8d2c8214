// Momentum of a model of blocks of any shape.
#pragma once

#include "model/world.h"

namespace quoin::blocks {

inline Vector linear_momentum(const World& w) {
  Vector p;
  for (const Body& b : w.bodies) p += b.mass * b.v;
  for (size_t i = 0; i < w.nodes.x.size(); ++i) p += w.nodes.mass[i] * w.nodes.v[i];
  return p;
}

inline Vector angular_momentum(const World& w, const Vector& about = {}) {
  // Velocities are half a step before positions; x - v dt/2 is the position at that time (cross(v, v) = 0).
  Vector l;
  for (const Body& b : w.bodies) l += b.momentum + b.mass * cross(b.x - about, b.v);
  for (size_t i = 0; i < w.nodes.x.size(); ++i) l += w.nodes.mass[i] * cross(w.nodes.x[i] - about, w.nodes.v[i]);
  return l;
}

}  // namespace quoin::blocks
