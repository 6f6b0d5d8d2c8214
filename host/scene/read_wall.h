// The part of a scene file that describes a wall (WallSpec); used by read_scene.cpp alone.
#pragma once

#include "scene/reader.h"

namespace quoin {

// After materials, joints and solver.
WallSpec read_wall(reader::Table& t, const Scene& scene);

}  // namespace quoin
