// What members of all kinds have in common.
#pragma once

#include <concepts>
#include <vector>

#include "members/node.h"

namespace quoin::members {

inline constexpr int kGround = -1;  // index of the ground, in place of a node

// Energies of members since the start, J.
struct Work {
  double stored = 0.0, dissipated = 0.0;
  double outside = 0.0;  // work of jacks and of the moving ground on members
  Work& operator+=(const Work& other) {
    stored += other.stored, dissipated += other.dissipated, outside += other.outside;
    return *this;
  }
};

// Kinds of members in drawings.
inline constexpr int kTie = 0, kStrip = 1, kFloor = 2, kBeam = 3, kDowel = 4;

// A stretch of a member in drawings.
struct Line {
  int kind = 0, member = 0;  // index among the members of the kind
  Vector from, to;           // m
  double force = 0.0;        // N, tension positive
  double plastic = 0.0;      // m
  double moment = 0.0;       // larger one of its ends, N m
  bool broken = false;
};

// Sum of the forces of points on their blocks, N; for members that are points of faces.
template <class Point>
Vector force_of(const std::vector<Point>& points) {
  Vector sum;
  for (const Point& p : points) sum += p.state.force;
  return sum;
}

// A kind of member. Beside these functions it has
//   each_joint(visit)          pairs of nodes that it connects: visit(node, node)
//   each_spring(visit)         bounds of its stiffness in any direction: visit(node, node or kGround, N/m)
//   each_number(visit)         numbers for the hash of the state: visit(number)
//   transfer(archive, member)  its state in checkpoints
// A kind that is drawn as lines has lines(nodes), whose `member` is set by Members.
template <class M>
concept Member = requires(M member, const M& held, std::vector<Node>& nodes, const Surroundings& step) {
  member.pull(nodes, step);  // adds forces to nodes; advances its own state by a step
  { held.work() } -> std::same_as<Work>;
  { held.columns() } -> std::same_as<std::vector<double>>;  // numbers of a row of history.csv, as in column_names
};

}  // namespace quoin::members
