// Stages in which bricks cannot stay on the lattice.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// Reason for which a run leaves the lattice at the begin of a stage, as messages have it; empty: none.
std::string leaves_lattice(const Scene& scene, std::size_t stage);

}  // namespace quoin
