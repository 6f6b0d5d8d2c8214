// New contact points of a pair of blocks.
#pragma once

#include <optional>
#include <vector>

#include "geometry/separation.h"
#include "model/contacts.h"

namespace quoin::blocks {

struct World;

// Cosine above which faces (within about 2.5 degrees of parallel) can be a joint of the start.
constexpr double parallel_cosine = 0.999;

struct NewPoint {
  Point point;
  Facet facet_a, facet_b;
  bool joint = true;  // within the joint tolerance at the start
};
// Points of a pair, by the feature that separates it. Sets Contact::beside_joint of blocks that meet along a rim.
void make_points(const World& w, Contact& c, const geometry::Separation& s, bool at_start, std::vector<NewPoint>& out);
// Largest opening of a contact's points that have tension, m; none: no point has.
std::optional<double> pulled_opening(const World& w, const Contact& c);
// Joint family of the contact for this normal; below 0: blocks declared to pass through each other.
int family_of(const World& w, const Contact& c, const geometry::Vector& normal);

}  // namespace quoin::blocks
