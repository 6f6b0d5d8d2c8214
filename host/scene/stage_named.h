// Stages by name, as commands ask for them.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// Index of the stage of that name; empty: the first. Throws Error(bad_input) with the names of the scene where none has
// it.
int stage_named(const Scene& scene, const std::string& name);

}  // namespace quoin
