// Damping ratios of the first modes of vibration under the damping of a stage.
#pragma once

#include "results/summary.h"

namespace quoin {

// Modes of the current state with the damping of a stage: zeta = phi C phi/(2 omega phi M phi). phi: shapes of the
// first modes without damping. C: viscosity of currently closed contacts, of zones and of masses. No modes where they
// would cost more than a few percent of the stage, on several ranks, and where damping is not viscous.
// StageModes::why_none then gives the reason.
StageModes damped_modes(const Simulation& simulation, int stage);

}  // namespace quoin
