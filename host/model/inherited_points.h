// History that contact points inherit when detection places them again.
#pragma once

#include <span>
#include <vector>

#include "model/contact_frames.h"
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

// Contact points that are replaced or lost, with their facets, before detection. By family and point: `location` is the
// current one, as they have moved along with their blocks. `closure` is the plastic closure since the point was placed,
// m.
struct PointsBefore {
  std::vector<Family> families;
  LaneVector<Facet> facets;
  std::vector<std::vector<Location>> location;
  std::vector<std::vector<double>> closure;
};

// Points of a contact and their facets: numbers of the originals (from) and of their copies (to). Copies are numbered
// from 0 without gaps, in the order of the list.
struct CopiedContact {
  int family;
  KeptItems points, facets;
};

// Changes the indices of a contact point's facets from `before` to `now`.
void move_facets(Point& p, uint32_t now, uint32_t before);
// Copies contact points and their facets.
PointsBefore set_aside(const World& w, std::span<const CopiedContact> contacts);
// A family of copies of points, numbered likewise; their facets are those of the originals.
Family copied_points(const Family& f, std::span<const KeptItems> points);
std::vector<Location> locations_of(const World& w, const Family& f, const LaneVector<Facet>& facets);
// Resizes columns of a family, facets, or data of pairs to `count` items; the kept ones move to their new indices.
void keep_points(const World& w, Family& f, std::span<const KeptItems> kept, size_t count);
void keep_facets(World& w, std::span<const KeptItems> kept, size_t count);
void keep_pairs(World& w, std::span<const KeptItems> kept, size_t count);
// Threads may call it for several contacts at a time.
void hand_over(World& w, const PointsBefore& before, const Finding& finding, const Contact& c,
               std::span<const NewPoint> points, bool at_start);
// Energy of each point of a family, J: stored at its current location, plus dissipated since the last step. This calls
// the law, so that `f` has the states and tractions after it.
std::vector<double> energies_of_points(const World& w, Family& f, std::span<const Location> locations);

}  // namespace quoin::blocks
