// Checks whether small displacements still describe a run. If not, it promotes the run, warns, or throws.
#pragma once

#include <string>
#include <vector>

#include "step/state.h"

namespace quoin {

// Checks the motion of blocks after a step, where due. Beyond a bound it promotes the run to large motion, warns, or
// throws Error(numerical). Returns whether it has promoted.
bool follow_motion(Simulation::Impl& s, bool stage_ends, std::vector<Warning>* warnings);
// Warns of a rotation_bound or sliding_bound of a scene that is in large motion from the start.
void warn_of_unused_bounds(Simulation::Impl& s, std::vector<Warning>* warnings);
bool was_warned(const Simulation::Impl& s, const char* about);
// Adds a warning, unless there is one about the same assumption. about: as in Warning.
void warn_once(Simulation::Impl& s, const char* about, const std::string& text, std::vector<Warning>* warnings);

}  // namespace quoin
