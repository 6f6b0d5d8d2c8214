// Broad phase: pairs of boxes that overlap, by a uniform grid. Cost grows linearly with the number of boxes.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"

namespace quoin::geometry {

struct Pair {
  int32_t a, b;  // a < b
  friend bool operator==(const Pair&, const Pair&) = default;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

// Sorted pairs of overlapping boxes; the caller inflates each box by half the skin. Boxes much larger than the rest (a
// floor) are tested against all others directly. Throws Error(numerical) with the index of a box that is not finite.
std::vector<Pair> overlapping_pairs(const std::vector<Box>& boxes);

}  // namespace quoin::geometry
