// Conversion of blocks of any shape to bricks of the lattice: the inverse of from_bricks.
#pragma once

#include <optional>
#include <string>

#include "scene/assembly.h"
#include "scene/blocks.h"

namespace quoin::blocks {

// Brick with the zones of a block that is a box along the axes, to rounding, turned by right angles or not. Nothing for
// other blocks.
std::optional<Brick> as_brick(const Assembly& assembly, int block);

// A scene of blocks on the lattice: brick i is block i. Joints have the order of those of walls: head joints course by
// course, then beds from the bottom up. The scene's stages control bodies of the bricks.
struct OnLattice {
  quoin::Assembly bricks;
  Scene scene;
};

// Converts a scene. Nothing, with the reason in *why_not, when a block, joint, stage or setting is not possible on the
// lattice. The lattice has boxes along the axes with conforming faces, in small displacements. Throws Error(bad_input)
// for a stage whose name of a block fits none, or two.
std::optional<OnLattice> to_bricks(const Assembly& assembly, const Scene& scene, std::string* why_not);

}  // namespace quoin::blocks
