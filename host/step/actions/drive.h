// Blocks that a stage moves, or loads at their centres; supports are such, and what is released.
#pragma once

#include "step/state.h"

namespace quoin {

// Along x, in place of what else is applied there.
void pull_block(Simulation::Impl& s, int block, double pull);

}  // namespace quoin
