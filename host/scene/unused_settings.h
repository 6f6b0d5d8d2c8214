// Settings of a scene that change nothing in it.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.h"

namespace quoin {

// One sentence a setting, which begins with its key.
std::vector<std::string> unused_settings(const Scene& scene);

}  // namespace quoin
