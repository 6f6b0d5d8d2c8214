// Ground motion of a stage: records, how they are scaled and corrected.
#pragma once

#include <string>

#include "scene/reader.h"

namespace quoin {

// folder: where files named by the scene are sought, with its slash.
GroundMotion read_ground(reader::Table t, const std::string& folder);

// A vector that has a direction.
void read_direction(reader::Table& t, const std::string& key, Vec3& direction, const char* what, bool required);

}  // namespace quoin
