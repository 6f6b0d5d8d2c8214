// Stages of walls and buildings: the short kinds, and custom ones of controls and actions.
#pragma once

#include <string>

#include "scene/reader.h"

namespace quoin {

// previous: null: it is the first. pressure: of the last pressure stage, which a shear stage may keep, Pa. folder: of
// the files that the scene names, with its slash.
Stage read_stage(reader::Table t, Scene& scene, const Stage* previous, double& pressure, const std::string& folder);

}  // namespace quoin
