// Joints of the start whose blocks have parted in large motion. They have no contact point, but keep the last state of
// their laws.
#pragma once

#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

struct PartedPoint {
  JointPoint joint;  // as the last contact point, at its place on block a. Its traction is 0, its opening is the
                     // current distance of the two sides, and contact.index is -1
  std::vector<double> state;  // state of its law, in the law's order
};

// Points of joints that begin at blocks [first, end), of which this rank must own all or have all. Empty in small
// displacements, where contact points remain.
std::vector<PartedPoint> parted_points(const Simulation& simulation, int first_block, int end_block);
std::vector<PartedPoint> parted_points(const Simulation& simulation);

}  // namespace quoin
