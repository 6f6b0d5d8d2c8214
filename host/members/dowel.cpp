#include "members/dowel.h"

#include <algorithm>
#include <cmath>

namespace quoin::members {

void DowelState::follow(const DowelLaw& law, const Vector& along, const Vector& apart) {
  const double opening = dot(apart, along);
  const double trial = law.axial * (opening - drawn);
  force = std::clamp(trial, -law.yield_force, law.yield_force);
  const double flow = (trial - force) / law.axial;
  drawn += flow;
  dissipated += force * flow;
  shear = law.shear * (apart - opening * along - slid);
  if (const double size = norm(shear); size > law.yield_shear) {
    const Vector slip = ((size - law.yield_shear) / (size * law.shear)) * shear;
    slid += slip;
    shear *= law.yield_shear / size;
    dissipated += dot(shear, slip);
  }
  stored = 0.5 * force * force / law.axial + 0.5 * dot(shear, shear) / law.shear;
}

}  // namespace quoin::members
