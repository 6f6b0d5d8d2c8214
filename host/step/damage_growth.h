// Growth of the damage of the joints, from which frames follow (output.frames_at_damage).
#pragma once

#include <vector>

#include "step/simulation.h"

namespace quoin {

inline constexpr long kMostFramesAtDamage = 200;  // of a stage

// Sums the damage of the joints after the step of a row, where that is due. Returns whether a frame shows it: the first
// time, and each time that it has grown enough. All ranks call it together.
bool damage_has_grown(Simulation::Impl& s, bool stage_ends, std::vector<Warning>* warnings);

}  // namespace quoin
