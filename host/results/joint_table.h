// Forces of the joints of a frame: sums over the contact points between two blocks.
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
  double area = 0.0;                  // m2, in contact; 0: the blocks have parted
  double normal = 0.0;                // Pa
  double shear = 0.0;                 // magnitude of the mean over both directions, Pa
  std::array<double, 3> force{};      // on the first block, N
  std::array<double, 3> direction{};  // direction of the normal, from the first block to the second
  std::array<double, 3> place{};      // centre of compression, or of the joint if there is none, m
  // Distance of the centre of compression from the middle of the joint, over the depth in its direction; 0.5: an edge.
  double eccentricity = 0.0;
  double opening = 0.0;  // largest, m
  double slip = 0.0;     // largest, m
  double damage = 0.0;   // largest, of tension and shear
  int crack = 0;         // the worst of its points
};
using BlockPair = std::pair<std::int32_t, std::int32_t>;  // the lower number first
std::map<BlockPair, JointSum> joint_sums(const VtuFile& joints);

// Sum of arm x force over the contact points of each block, symmetric, N m: xx yy zz xy yz zx. The arm is measured from
// `centre`. Divided by the volume it is the mean stress of a block without angular acceleration. Weight acts at the
// centre and adds nothing.
using Tensor = std::array<double, 6>;
std::map<std::int32_t, Tensor> force_moments(const VtuFile& joints,
                                             const std::map<std::int32_t, std::array<double, 3>>& centre);

}  // namespace quoin
