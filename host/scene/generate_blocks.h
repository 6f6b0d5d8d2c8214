// Generators of the general path: from a scene to blocks.
#pragma once

#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin::blocks {

// Throws Error(bad_input) for shapes that are not convex blocks, with the place in the scene file.
Assembly assemble(const Scene& scene);

// Indices of the blocks of that name: one, unless names are shared. Error(bad_input) with a suggestion when there is
// none.
std::vector<int> find_blocks(const Assembly& assembly, const std::string& name, const std::string& where);

}  // namespace quoin::blocks
