// What contact points go on with when detection places them again.
#pragma once

#include <span>
#include <vector>

#include "model/new_points.h"

namespace quoin::blocks {

struct World;

// What a pair has after detection, and had before.
struct Finding {
  bool examined = false;
  bool fresh = false;             // new points, or none any more
  size_t begin = 0;               // of its new points, where they are found here
  uint32_t fresh_count = 0;       // of these
  uint32_t first = 0, count = 0;  // its points of before, in their family
  uint32_t first_facet = 0;
};

// What contact points were before detection: families without their laws, and where they sat.
struct PointsBefore {
  std::vector<Family> families;
  LaneVector<Facet> facets;
};

void take_points(Family& f, Family& into);
void resize(const World& w, Family& f, size_t n);
// Of contacts that go on as they are, with so many facets.
void keep_points(World& w, const PointsBefore& before, const Finding& finding, const Contact& c, uint32_t facets);
void hand_over(World& w, const PointsBefore& before, const Finding& finding, const Contact& c,
               std::span<const NewPoint> points, bool at_start);
double energy_of_points(const World& w, const Family& f, const LaneVector<Facet>& facets, uint32_t first,
                        uint32_t count);

}  // namespace quoin::blocks
