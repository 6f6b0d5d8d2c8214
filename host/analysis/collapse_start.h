// Start multiplier of collapse stages with start = "limit".
#pragma once

#include "scene/scene.h"

namespace quoin {

// Sets the start of these stages, and their limit if they give none, by limit analysis of the scene. Throws as
// limit_of, with the stage. Throws Error(bad_input) where the program has no limit analysis.
void find_collapse_starts(Scene* scene);

}  // namespace quoin
