// Damage that masonry has before the first stage.
#pragma once

#include "scene/reader.h"

namespace quoin::reader {

// One [[damage]]; faults go to the context. What a law alone can judge is judged when the simulation is made.
Damage read_damage(Table& t, const Scene& scene);

}  // namespace quoin::reader
