// Bending of closed joints whose contact points lie at corners alone.
#pragma once

#include <string>

#include "step/simulation.h"

namespace quoin {

// Warning where such joints matter; empty: none. A closed rectangle of depth h has the rotational stiffness k A h^2/4
// on points at its corners, and k A h^2/12 by its area. So under a moment it turns by a third of what it should. The
// missing rotations 2 theta of a stack of n joints below a height H move its top by about theta H (1 + n). Limit cases:
// joints that open turn about their edges, where corners are right; stiff joints have no theta.
std::string bending_at_corners(const Simulation::Impl& s);

}  // namespace quoin
