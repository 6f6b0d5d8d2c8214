// Generators of the general path: from a scene to blocks.
#pragma once

#include "blocks/assembly.h"
#include "scene/scene.h"

namespace quoin::blocks {

// Throws Error(bad_input) for shapes that are not convex blocks, with the place in the scene file.
Assembly assemble(const Scene& scene);

// Index of the block of that name; Error(bad_input) with a suggestion when there is none.
int find_block(const Assembly& assembly, const std::string& name, const std::string& where);

}  // namespace quoin::blocks
