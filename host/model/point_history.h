// History of contact points when a run leaves small displacements.
#pragma once

#include <array>
#include <vector>

#include "geometry/vector.h"

namespace quoin::blocks {

struct World;

using geometry::Quaternion;
using geometry::Vector;

// History of a contact point of the start: its law's columns in a model of small displacements.
struct PointHistory {
  int block_a, block_b;              // the normal of the joint points from a to b
  Vector position, s, t;             // place at the start, m, and axes in the plane of the joint, unit
  double opening = 0.0;              // current opening, m
  double opening_at_traction = 0.0;  // opening at the last call of its law, m
  std::array<double, 2> slip{};      // slip along s and t since the last call of its law, m
  std::array<double, 3> traction{};  // Pa
  std::vector<double> state;
  std::vector<double> properties{};  // properties that scatter, in the order of the family's columns
};

// Order of calls when a run goes on from one in small displacements, before its first step. First the clock; then the
// pose of every rigid block, gridpoints and their velocities; then all contact points. adopt_histories keeps tractions,
// states and openings, whatever gap follows from the rotation of the blocks. It throws Error(numerical) when a history
// has no contact point in this model. Points without a history begin without load.
void set_pose(World& w, int block, const Vector& centre, const Quaternion& turn);  // rigid; turn: since the start
void adopt_histories(World& w, const std::vector<PointHistory>& histories);

}  // namespace quoin::blocks
