#include "members/fill.h"

#include <algorithm>
#include <cmath>

namespace quoin::members {

void FillState::follow(const FillLaw& law, double share, const Vector& now) {
  const double vertical = share * law.vertical, before = pressure, was_jacked = jack;
  outside -= law.upright * vertical * dot(now - moved, law.up);
  moved = now;
  jack = law.at_rest * vertical / law.stiffness;
  const double trial = law.stiffness * (dot(now, law.out) + jack - slid);
  pressure = std::clamp(trial, law.active * vertical, law.passive * vertical);
  const double flow = (trial - pressure) / law.stiffness;
  slid += flow;
  // Work of soil that follows a yielding wall comes from its weight.
  (flow > 0.0 ? dissipated : outside) += law.level * pressure * std::abs(flow);
  stored = 0.5 * law.level * pressure * pressure / law.stiffness;
  outside += 0.5 * law.level * (before + pressure) * (jack - was_jacked);
  force = -law.upright * vertical * law.up - law.level * pressure * law.out;
}

}  // namespace quoin::members
