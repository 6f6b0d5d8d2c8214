// Step of joints that act by the mean of the step (implicit_contacts.h).
#pragma once

#include "step/state.h"

namespace quoin {

void weigh_chunk(Simulation::Impl& s, int index, const ChunkJumps& jump, const double* normal_way);
void settle_contacts(Simulation::Impl& s);

}  // namespace quoin
