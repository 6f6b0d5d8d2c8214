// Joints of the start, and what is left of them where their blocks come apart.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/broad_phase.h"
#include "geometry/vector.h"
#include "model/contacts.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// A joint of the start, and its contact points then.
struct StartJoint {
  geometry::Pair pair;
  int family;
  uint32_t first, count;  // of StartJoints::point
};

struct StartPoint {
  Vector at;    // m
  double area;  // m2
};

// A contact point of the start where its blocks are no longer in contact (parted_points.cpp).
struct PartedPoint {
  int a, b, family;                // n points from block a to block b
  Vector side_a, side_b;           // where what was one place is now, on a and on b, m
  Vector n, s;                     // of the last contact point there, unit, turned along with a
  double area;                     // of the start, m2
  double normal_jump;              // of the last contact point there, m; and so:
  double traction[3];              // Pa
  std::vector<double> state;       // of the law
  std::vector<double> properties;  // that scatter, in the order of the family's columns
};

// Noted at the first detection; later ones keep what goes.
struct StartJoints {
  std::vector<StartJoint> joint;  // in the order of their pairs
  LaneVector<StartPoint> point;
  LaneVector<double> kept;  // of the last contact point at each of these, a row of numbers; empty: nothing yet
  bool any_replaced() const { return !kept.empty(); }
};

// Of joints that begin at blocks [first, end), in their order. With ranks of own blocks, after
// exchange_parted_blocks().
std::vector<PartedPoint> parted_points(const World& w, int first_block, int end_block);
void note_start_joints(World& w);
// Before the points of a joint go or are replaced: `count` of `old` from `first` on.
void keep_of_joint(World& w, const Contact& c, const Family& old, const LaneVector<Facet>& facets, uint32_t first,
                   uint32_t count);
size_t kept_width(const World& w);  // numbers of a row
void keep_states_by_id(World& w, int family, const quoin_law& old, size_t old_width);

}  // namespace quoin::blocks
