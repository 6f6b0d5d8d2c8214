// Monitors of a run, [[monitor]] of a scene.
#pragma once

#include <vector>

#include "scene/reader.h"
#include "scene/scene.h"

namespace quoin {

std::vector<Monitor> read_monitors(reader::Table& scene);

}  // namespace quoin
