// The order in which contact points are stored.
#pragma once

#include <cstdint>
#include <vector>

namespace quoin {

// The two gridpoints of a contact point, as offsets in lane layout; -1: of a rigid body by itself.
struct PointEnds {
  int family = 0, axis = 0, joint = 0;
  std::int32_t a = -1, b = -1;
};

// Indices in the order of storage: families, in them axes, in them chains of points whose gridpoints lie in one lane
// after the other. They do so on both sides where that is possible, else on one: vectors then load what lies side by
// side instead of gathering. Chains that fill lines of lanes come first: the others must not break their alignment.
std::vector<std::uint32_t> point_order(const std::vector<PointEnds>& points);

}  // namespace quoin
