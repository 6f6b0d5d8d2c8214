// Blocks of any shape that are bricks of the lattice after all: the inverse of from_bricks.
#pragma once

#include <optional>
#include <string>

#include "scene/assembly.h"
#include "scene/blocks.h"

namespace quoin::blocks {

// A block that is a box along the axes, to rounding, turned by right angles or not: its brick, with the same zones.
// Nothing for other blocks.
std::optional<Brick> as_brick(const Assembly& assembly, int block);

// What the lattice makes of a scene of blocks: brick i is block i. Joints are ordered as those of walls are, upright
// ones course by course, then beds from the bottom up. The scene's stages control bodies of the bricks.
struct OnLattice {
  quoin::Assembly bricks;
  Scene scene;
};

// Nothing, with the reason in *why_not, when some block, joint, stage or setting is not one of the lattice's. The
// lattice has boxes along the axes that touch in conforming faces, in small displacements. Throws Error(bad_input) for
// stages that name no block, or one of two.
std::optional<OnLattice> to_bricks(const Assembly& assembly, const Scene& scene, std::string* why_not);

}  // namespace quoin::blocks
