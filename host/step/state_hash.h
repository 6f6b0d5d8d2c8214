// Hash of a state, also where no rank holds all of it, and other results at the end of a run.
#pragma once

#include "step/state.h"

namespace quoin {

void end_run(Simulation::Impl& s);     // gathers the results that rank 0 writes
void note_start(Simulation::Impl& s);  // stores the hash of the start, where no rank can compute it alone

}  // namespace quoin
