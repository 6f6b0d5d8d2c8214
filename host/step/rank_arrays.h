// Transfer of an array, whose parts ranks hold, to rank 0, some megabytes at a time.
#pragma once

#include "step/state.h"

namespace quoin {

// whole: size of the array, bytes. take: called on rank 0 with pieces of the array, in order.
void give_array(Simulation::Impl& s, const void* array, std::size_t whole, const Simulation::TakeBytes& take);

}  // namespace quoin
