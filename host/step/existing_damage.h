// Damage of masonry before the first stage, as states of contact points. On the lattice: of the contact points that
// this rank evaluates.
#pragma once

#include "step/state.h"

namespace quoin {

void take_damage(Simulation::Impl& s);  // sets states and openings of the damaged points

}  // namespace quoin
