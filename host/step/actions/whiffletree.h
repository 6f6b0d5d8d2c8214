// A whiffletree: equal forces on floors, for blocks on the lattice and in large motion.
#pragma once

#include "step/state.h"

namespace quoin {

void bind_whiffletree(Simulation::Impl& s);  // bodies and blocks of the stage's floors
// Mean displacement of the floor's bodies and blocks along x, m. At the current time, and at that of the last forces,
// one step before.
double floor_displacement_now(const Simulation::Impl& s, std::size_t floor);
double floor_displacement(const Simulation::Impl& s, std::size_t floor);
void pull_whiffletree(Simulation::Impl& s);

}  // namespace quoin
