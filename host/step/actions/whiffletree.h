// Floors of a building and the whiffletree that pulls them, for blocks on the lattice and in large motion.
#pragma once

#include "step/state.h"

namespace quoin {

void bind_floors(Simulation::Impl& s);  // bodies and blocks of the stage's floors
// Places the head of the jack where a stage begins. The force goes on from the stage before.
void begin_pull(Simulation::Impl& s, const Stage* previous);
void pull_whiffletree(Simulation::Impl& s);

}  // namespace quoin
