// Lengths of bricks along their axes, and what two of them share.
#pragma once

#include <algorithm>

#include "scene/assembly.h"

namespace quoin {

inline double least_extent(const Brick& brick) { return *std::ranges::min_element(brick.size); }

struct Overlap {
  Vec3 from, to;                                                        // m
  double gap(std::size_t axis) const { return from[axis] - to[axis]; }  // > 0 apart, < 0 shared length, m
};
inline Overlap overlap_of(const Brick& a, const Brick& b) {
  Overlap shared{};
  for (std::size_t c = 0; c < 3; ++c) {
    shared.from[c] = std::max(a.origin[c], b.origin[c]);
    shared.to[c] = std::min(a.origin[c] + a.size[c], b.origin[c] + b.size[c]);
  }
  return shared;
}

}  // namespace quoin
