// What contact points go on from when a run leaves small displacements.
#pragma once

#include <array>
#include <vector>

#include "geometry/vector.h"

namespace quoin::blocks {

struct World;

using geometry::Quaternion;
using geometry::Vector;

// What a contact point of the start goes on from: its law's columns in a model of small displacements.
struct PointHistory {
  int block_a, block_b;              // the normal of the joint points from a to b
  Vector position, s, t;             // place at the start, m, and axes in the plane of the joint, unit
  double opening = 0.0;              // opening at the next call of its law, m
  double opening_at_traction = 0.0;  // opening at the last call of its law, m
  std::array<double, 2> slip{};      // along s and t, that its law has not seen yet, m
  std::array<double, 3> traction{};  // Pa
  std::vector<double> state;
  std::vector<double> properties{};  // properties that scatter, in the order of the family's columns
};

// A run goes on from one in small displacements (adopt_histories.cpp), before the first step. Clock; then the pose of
// every rigid block, gridpoints and their velocities; then all contact points. adopt_histories keeps tractions, states
// and openings as they are, whatever the turning of the blocks means for the gap. Throws Error(numerical) when a
// history has no contact point here. Points without a history begin without load.
void set_pose(World& w, int block, const Vector& centre, const Quaternion& turn);  // rigid; turn: since the start
void adopt_histories(World& w, const std::vector<PointHistory>& histories);

}  // namespace quoin::blocks
