// Pairs of blocks close to each other.
#pragma once

#include "geometry/broad_phase.h"
#include "geometry/separation.h"
#include "model/contact_points.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Vector;

// Two blocks close to each other: what every process has of them.
struct Contact {
  geometry::Pair pair;
  int family = -1;
  uint32_t first = 0, count = 0;  // points in Family::point
  uint32_t first_facet = 0;       // index of the contact's first facet point in Contacts::facets
  bool initial = false;           // a joint of the start
  bool beside_joint = false;      // blocks that only touch along an edge or at a corner since the start
};

// The same pair at its last narrow detection.
struct PairPlace {
  geometry::Separation separation;
  Vector relative_x;  // pose of b seen from a
  Matrix relative_r;
};

// Detection makes them; steps change the points. With ranks all have the list, and points of own pairs.
struct Contacts {
  std::vector<Contact> list;    // contacts in the order of their pairs
  LaneVector<PairPlace> place;  // place of each contact
  std::vector<Family> families;
  std::vector<std::vector<uint32_t>> of_family;  // indices of those that have points
  LaneVector<Facet> facets;                      // family after family, in the order of points
};

}  // namespace quoin::blocks
