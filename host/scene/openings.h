// Cells of a wall of half units that are in openings and lintels.
#pragma once

#include <algorithm>
#include <vector>

#include "scene/scene.h"

namespace quoin {

inline bool in_opening(const std::vector<WallSpec::Opening>& openings, int course, int half_unit) {
  return std::any_of(openings.begin(), openings.end(),
                     [&](const WallSpec::Opening& o) { return o.covers(course, half_unit); });
}

// Opening whose lintel covers the cell, or null.
inline const WallSpec::Opening* lintel_at(const std::vector<WallSpec::Opening>& openings, int course, int half_unit) {
  const auto found = std::find_if(openings.begin(), openings.end(),
                                  [&](const WallSpec::Opening& o) { return o.lintel_covers(course, half_unit); });
  return found == openings.end() ? nullptr : &*found;
}

}  // namespace quoin
