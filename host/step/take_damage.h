// Damage of the scene, before the first stage: on the lattice of the contact points that this rank evaluates.
#pragma once

#include "step/state.h"

namespace quoin {

void take_damage(Simulation::Impl& s);  // sets states and openings of the damaged points

}  // namespace quoin
