// Where a collapse stage with start = "limit" begins.
#pragma once

#include "scene/scene.h"

namespace quoin {

// Gives these stages their start, and a limit where they have none, by limit analysis of the scene. Throws Error as
// limit_of, with the stage, and Error(bad_input) where the program has no limit analysis.
void find_collapse_starts(Scene* scene);

}  // namespace quoin
