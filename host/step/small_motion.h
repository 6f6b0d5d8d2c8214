// Whether a run may go on in small displacements: when that is checked, and what follows.
#pragma once

#include <string>
#include <vector>

#include "step/state.h"

namespace quoin {

std::string past_motion_bound(const Simulation::Impl& s);  // bound that is exceeded, and where; empty: none
// After a step: goes over to large motion where blocks have moved too far, or warns, or throws Error(numerical).
// Whether it has gone over.
bool follow_motion(Simulation::Impl& s, bool stage_ends, std::vector<Warning>* warnings);
bool was_warned(const Simulation::Impl& s, const char* about);
// about: as in Warning.
void warn_once(Simulation::Impl& s, const char* about, const std::string& text, std::vector<Warning>* warnings);

}  // namespace quoin
