// Pairs of blocks close to each other.
#pragma once

#include <array>

#include "geometry/broad_phase.h"
#include "geometry/separation.h"
#include "model/contact_points.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Vector;

// A pair of blocks close to each other, on every rank.
struct Contact {
  geometry::Pair pair;
  int family = -1;
  uint32_t first = 0, count = 0;  // points in Family::point
  uint32_t first_facet = 0;       // index of the contact's first facet point in Contacts::facets
  std::uint16_t initial = 0;      // 1: it is a joint of the start
  // Reason why corners have no nominal area. 1: the blocks touch only along an edge or at a corner since the start.
  // kOnRim: they have met along a rim, and their overlap is small since.
  std::uint16_t beside_joint = 0;
  static constexpr std::uint16_t kOnRim = 2;
};

// A pair at its last narrow phase.
struct PairPlace {
  geometry::Separation separation;
  Vector relative_x;  // pose of b in the frame of a
  Matrix relative_r;
  std::array<double, 2> viscosity{};  // of impact damping, over stiffness, normal to the joint and along it, s
};

// Detection makes contacts; steps change their points. Every rank has the list, but only points of own pairs.
struct Contacts {
  std::vector<Contact> list;    // contacts in the order of their pairs
  LaneVector<PairPlace> place;  // by contact
  std::vector<Family> families;
  std::vector<std::vector<uint32_t>> of_family;  // indices of contacts with points, by family
  LaneVector<Facet> facets;                      // family after family, in the order of points
};

}  // namespace quoin::blocks
