// Generators of scenes of blocks of any shape.
#pragma once

#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin::blocks {

// Blocks of a scene. Throws Error(bad_input), with the place in the scene file, for shapes that are not convex.
Assembly assemble(const Scene& scene);

// Marks fixed blocks that some stage frees. They have joints with other fixed blocks, too.
void mark_freed_blocks(const Scene& scene, Assembly* assembly);

// Indices of the blocks with a name, their own or that in stages: one, unless names are shared. Throws Error(bad_input)
// with a suggestion when there is none.
std::vector<int> find_blocks(const Assembly& assembly, const std::string& name, const std::string& where);

}  // namespace quoin::blocks
