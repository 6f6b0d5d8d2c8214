// The order in which contact points are stored.
#pragma once

#include <cstdint>
#include <vector>

namespace quoin {

// The two gridpoints of a contact point, as offsets in lane layout; -1: the side of a lone rigid body.
struct PointEnds {
  int family = 0, axis = 0, joint = 0;
  std::int32_t a = -1, b = -1;
};

// Indices in the order of storage: by family, then by axis, then in chains. Points of a chain have gridpoints in
// consecutive lanes, on both sides where possible, else on one side. So vector loads replace gathers. Chains that fill
// whole lines come first, as the others would break their alignment.
std::vector<std::uint32_t> point_order(const std::vector<PointEnds>& points);

}  // namespace quoin
