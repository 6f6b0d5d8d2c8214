// A law swap on the lattice. Each rank swaps its own contact points: a law evaluates each point independently.
#pragma once

#include "step/state.h"

namespace quoin {

// Takes the bounds of the law's stiffness for a joint family where they are larger than those so far, which choose the
// time step. Returns whether one is.
bool take_stiffness(Simulation::Impl& s, std::size_t f, const Material& material);
void swap_lattice_law(Simulation::Impl& s, std::size_t f, std::shared_ptr<const Material> material);

}  // namespace quoin
