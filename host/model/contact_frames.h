// Places of contact points, and their axes.
#pragma once

#include <array>
#include <iterator>
#include <utility>

#include "model/contact_points.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

struct Location {
  Vector at;                                // position in space, m
  double jump = 0.0, slid[2] = {0.0, 0.0};  // normal jump; position along s and t in a's frame, m
};
Location locate(const World& w, const Point& p, const LaneVector<Facet>& facets);
Vector in_space(const World& w, const Point& p, const Vector& v);  // a vector of the point's frame, in space

// n of a triangle, s along its first edge.
struct TriangleFrame {
  Vector n, s, t;
  ShapeGradients gradient;
};
// Shares of the corners x, y, z of a triangle at the foot of a place on its plane; their sum is 1. Given: y - x,
// z - x, place - x.
std::array<double, 3> corner_shares(const Vector& y, const Vector& z, const Vector& place);
TriangleFrame triangle_frame(const LaneVector<Vector>& gridpoints, const Facet& facet);
void take_axes(Point& p, const TriangleFrame& frame);
void move_foot(Facet& facet, const ShapeGradients& gradient, double along_s, double along_t);  // m
void keep_opening(Point& p, double jump, double opening);  // moves the zero of a point whose jump is now `jump`, m
void take_back_facets(World& w);                           // copies frames and feet from lanes to points
void leave_gridpoints(World& w, Family& f, size_t point);  // frame: from block a to its triangle

// Components along s and t of a vector that lies nearly in their plane; its size is kept.
std::pair<double, double> turned_into(const Vector& s, const Vector& t, const Vector& v);
// Turns the vectors that contact points have along s and t: turn(old s, old t, new s, new t), arrays by point.
template <class Turn>
void turn_joint_vectors(const Family& old, Family& f, const Turn& turn) {
  turn(old.traction[1], old.traction[2], f.traction[1], f.traction[2]);
  if (!old.viscous[0].empty() && !f.viscous[0].empty())
    turn(old.viscous[1], old.viscous[2], f.viscous[1], f.viscous[2]);
  for (size_t k = 0; k < std::size(f.maxwell) && !old.maxwell[k].empty() && !f.maxwell[k].empty(); k += 3)
    turn(old.maxwell[k + 1], old.maxwell[k + 2], f.maxwell[k + 1], f.maxwell[k + 2]);
  for (size_t k = 0; k + 1 < f.state.size(); ++k) {
    if (f.material->api().states[k]->kind == QUOIN_STATE_PAIR_S)
      turn(old.state[k], old.state[k + 1], f.state[k], f.state[k + 1]);
  }
}

}  // namespace quoin::blocks
