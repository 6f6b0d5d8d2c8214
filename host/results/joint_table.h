// What the joints of a frame carry: the contact points between two blocks together.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "results/read_vtu.h"

namespace quoin {

// Sums over a pair of blocks. Tractions are means over the area in contact, tension positive.
struct JointSum {
  double area = 0.0;                  // in contact, m2; 0: the blocks have come apart
  double normal = 0.0;                // Pa
  double shear = 0.0;                 // resultant of both directions, Pa
  std::array<double, 3> force{};      // on the first block, N
  std::array<double, 3> direction{};  // direction of the normal, from the first block to the second
  std::array<double, 3> place{};      // centre of the compression, or of the joint where there is none, m
  // Distance of the compression from the middle of the joint, over its depth that way; 0.5: an edge.
  double eccentricity = 0.0;
  double opening = 0.0;  // largest, m
  double slip = 0.0;     // largest, m
  double damage = 0.0;   // largest, of tension and shear
  int crack = 0;         // the worst
};
using BlockPair = std::pair<std::int32_t, std::int32_t>;  // the smaller number first
std::map<BlockPair, JointSum> joint_sums(const VtuFile& joints);

// Of blocks the sum of arm x force over their contact points, symmetric, N m: xx yy zz xy yz zx. The arm leads from
// `centre`. Over the volume it is the mean stress of a block that does not spin faster and faster; its weight adds
// nothing to that.
using Tensor = std::array<double, 6>;
std::map<std::int32_t, Tensor> force_moments(const VtuFile& joints,
                                             const std::map<std::int32_t, std::array<double, 3>>& centre);

}  // namespace quoin
