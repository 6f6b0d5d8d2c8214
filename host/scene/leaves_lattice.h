// Which stages bricks on the lattice do not have.
#pragma once

#include <string>

#include "scene/scene.h"

namespace quoin {

// What a run leaves the lattice for when this stage begins, in the words of messages; empty: nothing.
std::string leaves_lattice(const Scene& scene, std::size_t stage);

}  // namespace quoin
