// Damage of masonry before the first stage.
#pragma once

#include "scene/reader.h"

namespace quoin::reader {

// Reads one [[damage]]; faults go to the context. Properties of laws are checked when the simulation is made.
Damage read_damage(Table& t, const Scene& scene);

}  // namespace quoin::reader
