// Existing damage, set before the first stage. On the lattice: of the contact points that this rank evaluates.
#pragma once

#include "step/state.h"

namespace quoin {

void take_damage(Simulation::Impl& s);  // sets states and openings of the damaged points

}  // namespace quoin
