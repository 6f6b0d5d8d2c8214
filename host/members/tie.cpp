#include "members/tie.h"

#include <algorithm>
#include <cmath>

namespace quoin::members {

void TieState::follow(const TieLaw& law, double elongation, double jack) {
  if (broken) return;
  const double before = force, was_shortened = shortening;
  shortening = jack * law.pretension / law.stiffness;
  const double stretched = elongation + shortening - law.slack;
  if (stretched > law.rupture) {
    dissipated += stored;
    force = stored = 0.0, broken = true;
    return;
  }
  const double trial = law.stiffness * (stretched - plastic), back = law.hardening * plastic;
  const double beyond = trial > law.yield + back                      ? trial - law.yield - back
                        : law.compression && trial < back - law.yield ? trial + law.yield - back
                                                                      : 0.0;
  const double flow = beyond / (law.stiffness + law.hardening);
  plastic += flow;
  dissipated += law.yield * std::abs(flow);
  force = trial - law.stiffness * flow;
  if (!law.compression) force = std::max(force, 0.0);
  stored = 0.5 * force * force / law.stiffness + 0.5 * law.hardening * plastic * plastic;
  jack_work += 0.5 * (before + force) * (shortening - was_shortened);
}

}  // namespace quoin::members
