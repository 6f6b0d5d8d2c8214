// The table of a wall (WallSpec).
#pragma once

#include "scene/reader.h"

namespace quoin {

// Requires that materials, joints and solver have been read.
WallSpec read_wall(reader::Table& t, const Scene& scene);

}  // namespace quoin
