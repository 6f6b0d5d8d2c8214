// An array whose parts ranks hold, some megabytes at a time, to rank 0.
#pragma once

#include "step/state.h"

namespace quoin {

// take: of rank 0, which gets the array in order.
void give_array(Simulation::Impl& s, const void* array, std::size_t whole, const Simulation::TakeBytes& take);

}  // namespace quoin
