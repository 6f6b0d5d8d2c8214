// Stages of walls and buildings: the short kinds, and custom ones with controls and actions.
#pragma once

#include <string>

#include "scene/reader.h"

namespace quoin {

// previous: the stage before; null: this is the first. pressure: that of the last pressure stage, which later stages
// may keep, Pa. folder: that of files named by the scene, with its slash.
Stage read_stage(reader::Table t, Scene& scene, const Stage* previous, double& pressure, const std::string& folder);

}  // namespace quoin
