// Walls and buildings of bricks as blocks of any shape, for large motion.
#pragma once

#include "blocks/assembly.h"
#include "scene/assembly.h"

namespace quoin::blocks {

// The same blocks, zones and joints: gridpoints and contact points are where the lattice has them. Rigid bricks carry
// the names of their bodies; pairs that the assembly does not join are of the family of its first bed joint, and
// without bond, as all that meets later is. Throws Error(bad_input) for what large motion cannot do yet: half of the
// thickness, bodies of several bricks, stages with a whiffletree or on deformable bodies.
Assembly from_bricks(const quoin::Assembly& bricks, const Scene& scene);

}  // namespace quoin::blocks
