// What contact points go on with when detection places them again.
#pragma once

#include <span>
#include <vector>

#include "model/kept_items.h"
#include "model/new_points.h"

namespace quoin::blocks {

struct World;

// What a pair has after detection, and had before.
struct Finding {
  bool known = false;  // close before
  bool examined = false;
  bool fresh = false;             // new points, or none any more
  size_t begin = 0;               // index of its first new point, where this process finds them
  uint32_t fresh_count = 0;       // number of its new points
  uint32_t first = 0, count = 0;  // its old points in their family
  uint32_t first_facet = 0;
};

// Contact points that are replaced, or go, as they were before: families without their laws, and where they sat.
struct PointsBefore {
  std::vector<Family> families;
  LaneVector<Facet> facets;
};

Family without_points(const Family& f);  // another one of the same law
// Changes the indices of a contact point's facets from `before` to `now`.
void move_facets(Point& p, uint32_t now, uint32_t before);
// Copies points [first, first + count) of a contact, and their facets; first ones are then those of the copies.
void set_aside(const World& w, const Contact& c, uint32_t& first, uint32_t& first_facet, uint32_t count,
               PointsBefore& before);
// Columns of a family, facets, or what pairs have, in which these go on.
void keep_points(const World& w, Family& f, std::span<const KeptItems> kept, size_t count);
void keep_facets(World& w, std::span<const KeptItems> kept, size_t count);
void keep_pairs(World& w, std::span<const KeptItems> kept, size_t count);
void hand_over(World& w, const PointsBefore& before, const Finding& finding, const Contact& c,
               std::span<const NewPoint> points, bool at_start);
double energy_of_points(const World& w, const Family& f, const LaneVector<Facet>& facets, uint32_t first,
                        uint32_t count);

}  // namespace quoin::blocks
