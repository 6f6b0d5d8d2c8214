// Joints of the start whose blocks have come so far apart in large motion that no contact point is left of them.
#pragma once

#include <vector>

#include "step/simulation.h"

namespace quoin {

struct PartedJoint {
  int block_a, block_b;
  std::vector<Vec3> side_a, side_b;  // the two sides of what were its contact points, where they are now, m
  double opening;                    // the widest distance between them, m
};

// None in small displacements, whose contact points stay.
std::vector<PartedJoint> parted_joints(const Simulation& simulation);

}  // namespace quoin
