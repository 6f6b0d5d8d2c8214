// Joints of the start, and the last state of their points where blocks have come apart.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/broad_phase.h"
#include "geometry/vector.h"
#include "model/contact_frames.h"
#include "model/contacts.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// A joint of the start, and its contact points.
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
  int a, b, family;                // n points from block a to block b
  Vector side_a, side_b;           // current positions on a and on b of the point's place at the start, m
  Vector n, s;                     // axes of the last contact point there, unit, turned with block a
  double area;                     // area at the start, m2
  double normal_jump;              // opening of the last contact point there, m; so are the numbers below
  double traction[3];              // Pa
  std::vector<double> state;       // state of the law
  std::vector<double> properties;  // properties that scatter, in the order of the family's columns
};

// First detection writes the joints; later detections store points that are replaced or lost.
struct StartJoints {
  std::vector<StartJoint> joint;  // joints in the order of their pairs
  LaneVector<StartPoint> point;
  // Values of the last contact point at each start point, row by row; empty: no point was replaced yet.
  LaneVector<double> kept;
  bool any_replaced() const { return !kept.empty(); }
};

// Parted points of joints whose first block is in [first_block, end_block), in order. With ranks: of own blocks, after
// exchange_parted_blocks().
std::vector<PartedPoint> parted_points(const World& w, int first_block, int end_block);
void note_start_joints(World& w);
// Stores the points of a joint before they are lost or replaced: points of `old` from `first` on, by location. Threads
// may call it for several joints at a time.
void keep_of_joint(World& w, const Contact& c, const Family& old, std::span<const Location> locations, uint32_t first);
size_t kept_width(const World& w);  // numbers per row of StartJoints::kept
void keep_states_by_id(World& w, int family, const quoin_law& old, size_t old_width);

}  // namespace quoin::blocks
