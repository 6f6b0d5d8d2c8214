// Ground motion of a stage: its records, their scale and correction.
#pragma once

#include <string>

#include "scene/reader.h"

namespace quoin {

// folder: that of files named by the scene, with its slash.
GroundMotion read_ground(reader::Table t, const std::string& folder);

// Whether a scale is that of accelerations in g, which files that state their unit refuse.
bool converts_from_g(double scale);

// Reads a vector that is not 0.
void read_direction(reader::Table& t, const std::string& key, Vec3& direction, const char* what, bool required);

}  // namespace quoin
