// A law swap on the lattice. Each rank swaps its own contact points: a law evaluates each point independently.
#pragma once

#include "step/state.h"

namespace quoin {

void swap_lattice_law(Simulation::Impl& s, std::size_t f, std::shared_ptr<const Material> material);

}  // namespace quoin
