// The hash of a state, also of one of which no rank has all, and what else the end of a run keeps of it.
#pragma once

#include "step/state.h"

namespace quoin {

void end_run(Simulation::Impl& s);     // results that rank 0 needs
void note_start(Simulation::Impl& s);  // the hash, where no rank can compute it alone

}  // namespace quoin
