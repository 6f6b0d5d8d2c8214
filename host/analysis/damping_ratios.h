// What the damping of the stage of now does to the first modes of vibration.
#pragma once

#include "results/summary.h"

namespace quoin {

// Of a stage that begins now: zeta = phi C phi/(2 omega phi M phi). phi: shapes of the first modes without damping. C
// is the viscosity of contacts that are closed now, of zones and of masses. None where that would cost more than a few
// percent of the stage, on ranks, and where the damping is no viscosity. StageModes::why_none gives the reason.
StageModes damped_modes(const Simulation& simulation, int stage);

}  // namespace quoin
