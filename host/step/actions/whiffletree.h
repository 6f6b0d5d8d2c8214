// Floors of a building and the whiffletree that pulls them, for blocks on the lattice and in large motion.
#pragma once

#include "step/state.h"

namespace quoin {

void bind_floors(Simulation::Impl& s);  // bodies and blocks of the stage's floors
// Mean displacement of the floor's bodies and blocks, m. At the current time, and at that of the last forces, one step
// before.
Vec3 floor_displacement_now(const Simulation::Impl& s, const Floor& floor);
Vec3 floor_displacement(const Simulation::Impl& s, const Floor& floor);
void pull_whiffletree(Simulation::Impl& s);

}  // namespace quoin
