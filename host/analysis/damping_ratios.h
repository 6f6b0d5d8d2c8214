// What the damping of the stage of now does to the first modes of vibration.
#pragma once

#include "results/summary.h"

namespace quoin {

// Of a stage that begins now: zeta = phi C phi/(2 omega phi M phi) for the shapes phi of the first modes without
// damping, with the viscosity C of contacts that are closed now, of zones and of masses. Not where that would cost more
// than a few percent of the stage, on ranks, and where the damping is no viscosity: StageModes::why_none says so.
StageModes damped_modes(const Simulation& simulation, int stage);

}  // namespace quoin
