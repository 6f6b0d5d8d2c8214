#include "members/spring.h"

#include <algorithm>
#include <cmath>

namespace quoin::members {

void SpringState::follow(const SpringLaw& law, const Vector& out, const Vector& now, double dt) {
  const Vector way = now - moved, sheared = moved - dot(moved, out) * out - slid;
  moved = now;
  const double sunk = dot(now, out), way_in = dot(way, out);
  const Vector along = now - sunk * out, way_along = way - way_in * out;
  const double pressing = law.normal * sunk;
  const bool closed = law.tension || pressing > 0.0;
  if (!closed) {  // shear energy is lost; shear begins at 0 when the block touches again
    if (stored > 0.0) dissipated += 0.5 * law.shear * dot(sheared, sheared);
    slid = along;
    force = {}, stored = 0.0;
    return;
  }
  Vector shear = law.shear * (along - slid);
  const double allowed = law.friction * std::max(0.0, pressing), size = norm(shear);
  if (size > allowed) {
    const Vector slip = ((size - allowed) / (size * law.shear)) * shear;
    slid += slip;
    shear *= allowed / size;
    dissipated += dot(shear, slip);
  }
  stored = 0.5 * law.normal * sunk * sunk + (law.shear > 0.0 ? 0.5 * dot(shear, shear) / law.shear : 0.0);
  double damping = law.normal_dashpot * way_in / dt;
  if (!law.tension) damping = std::max(damping, -pressing);
  const Vector damping_along = (law.shear_dashpot / dt) * way_along;
  dissipated += damping * way_in + dot(damping_along, way_along);
  force = -(pressing + damping) * out - shear - damping_along;
}

}  // namespace quoin::members
