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
  uint32_t first, count;  // indices into StartJoints::point
};

struct StartPoint {
  Vector at;    // m
  double area;  // m2
};

// A contact point of the start where its blocks are no longer in contact (parted_points.cpp).
struct PartedPoint {
  int a, b, family;           // n points from block a to block b
  Vector side_a, side_b;      // current places, on a and on b, of what was one place, m
  Vector n, s;                // axes of the last contact point there, unit, turned along with a
  double area;                // area at the start, m2
  double normal_jump;         // opening of the last contact point there, m; the numbers below are of that point too
  double traction[3];         // Pa
  std::vector<double> state;  // state of the law
  std::vector<double> properties;  // properties that scatter, in the order of the family's columns
};

// Noted at the first detection; later ones keep what goes.
struct StartJoints {
  std::vector<StartJoint> joint;  // joints in the order of their pairs
  LaneVector<StartPoint> point;
  // Numbers of the last contact point at each of these, row by row; empty: no point was lost yet.
  LaneVector<double> kept;
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
