// Members. Their pretension grows over the ramp of the first stage.
#pragma once

#include "step/state.h"

namespace quoin {

void build_members(Simulation::Impl& s);  // members of the scene

}  // namespace quoin
