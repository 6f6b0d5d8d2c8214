// Blocks with prescribed velocities, or with forces at their centres: supports, driven blocks and released ones.
#pragma once

#include "step/state.h"

namespace quoin {

// Sets the force along x, N, in place of that of the stage.
void pull_block(Simulation::Impl& s, int block, double pull);

}  // namespace quoin
