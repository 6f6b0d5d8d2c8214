// History that contact points inherit when detection places them again.
#pragma once

#include <span>
#include <vector>

#include "model/kept_items.h"
#include "model/new_points.h"

namespace quoin::blocks {

struct World;

// Contact points of a pair before and after detection.
struct Finding {
  bool known = false;  // whether the pair was within the skin before
  bool examined = false;
  bool fresh = false;             // whether its points are replaced by new ones or by none
  size_t begin = 0;               // index of its first new point in the list of this process
  uint32_t fresh_count = 0;       // number of its new points
  uint32_t first = 0, count = 0;  // its old points in their family
  uint32_t first_facet = 0;
};

// Contact points that are replaced or lost, with their facets, before detection: families without their laws.
struct PointsBefore {
  std::vector<Family> families;
  LaneVector<Facet> facets;
};

Family without_points(const Family& f);  // an empty family with the same law
// Changes the indices of a contact point's facets from `before` to `now`.
void move_facets(Point& p, uint32_t now, uint32_t before);
// Copies points [first, first + count) of a contact, and their facets. Sets first and first_facet to those of the
// copies.
void set_aside(const World& w, const Contact& c, uint32_t& first, uint32_t& first_facet, uint32_t count,
               PointsBefore& before);
// Resizes columns of a family, facets, or data of pairs to `count` items; the kept ones move to their new indices.
void keep_points(const World& w, Family& f, std::span<const KeptItems> kept, size_t count);
void keep_facets(World& w, std::span<const KeptItems> kept, size_t count);
void keep_pairs(World& w, std::span<const KeptItems> kept, size_t count);
void hand_over(World& w, const PointsBefore& before, const Finding& finding, const Contact& c,
               std::span<const NewPoint> points, bool at_start);
double energy_of_points(const World& w, const Family& f, const LaneVector<Facet>& facets, uint32_t first,
                        uint32_t count);

}  // namespace quoin::blocks
