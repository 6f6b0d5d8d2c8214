// Equal forces on floors, of blocks on the lattice and in large motion.
#pragma once

#include "step/state.h"

namespace quoin {

void bind_whiffletree(Simulation::Impl& s);  // bodies and blocks of the stage's floors
// Along x, of the floor's bodies and blocks on average, m. As displacements are now; and at the time of the last
// forces, a step before.
double floor_displacement_now(const Simulation::Impl& s, std::size_t floor);
double floor_displacement(const Simulation::Impl& s, std::size_t floor);
void pull_whiffletree(Simulation::Impl& s);

}  // namespace quoin
