// Impact damping in large motion.
#pragma once

#include <array>
#include <vector>

#include "model/maxwell.h"

namespace quoin::blocks {

struct World;

// Impact damping. That of the settings is chosen when they change, the share in use with the time step.
struct ImpactState {
  std::vector<double> beta;  // of the settings: viscosity over stiffness, normal and along the joint by family, s
  double zone_beta = 0.0;    // of the settings: stiffness-proportional damping of zones, s
  double rate = 0.0;         // of the settings: largest eigenvalue of viscosity over inertia, 1/s
  double share = 1.0;        // damping in use over that of the settings
  std::array<MaxwellElement, kMaxwellElements> maxwell{};
};

void choose_impact_damping(World& w);
// Share of critical that the time step leaves of solver.impact_damping; 0: damping is not that of impacts.
double impact_damping_in_use(const World& w);

}  // namespace quoin::blocks
