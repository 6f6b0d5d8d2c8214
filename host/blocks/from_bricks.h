// Walls and buildings of bricks as blocks of any shape, for large motion.
#pragma once

#include "blocks/assembly.h"
#include "scene/assembly.h"

namespace quoin::blocks {

// The same blocks, zones and joints: gridpoints and contact points are where the lattice has them. Rigid bricks carry
// the names of their bodies; pairs that the assembly does not join are of the family of its first bed joint, and
// without bond, as all that meets later is.
Assembly from_bricks(const quoin::Assembly& bricks);

// Damping and inertia for it: eq. 1 with true inertia where the scene has damping by block or inertia scaled apart,
// which blocks of any shape do not have.
SolverSettings for_large_motion(const SolverSettings& solver);

}  // namespace quoin::blocks
