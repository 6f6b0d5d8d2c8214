// Joints of the start where their blocks have come apart in large motion. No contact point is left there, but the last
// state of the joint stays.
#pragma once

#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

struct PartedPoint {
  JointPoint joint;  // as its last contact point, on block a, but for the traction, which is 0, and the opening,
                     // which is the distance of now between the two sides; contact.index: -1
  std::vector<double> state;  // state of its law, in the law's order
};

// Of joints that begin at blocks [first, end), which this rank must own or have all of. None in small displacements,
// whose contact points stay.
std::vector<PartedPoint> parted_points(const Simulation& simulation, int first_block, int end_block);
std::vector<PartedPoint> parted_points(const Simulation& simulation);

}  // namespace quoin
