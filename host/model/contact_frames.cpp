#include "model/contact_frames.h"

#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

Vector in_space(const World& w, const Point& p, const Vector& v) {
  if (p.on_gridpoints) return rotation_of_frame(w, p.a) * v;
  return p.facet_a >= 0 || w.blocks[p.a].body < 0 ? v : w.bodies[w.blocks[p.a].body].r * v;
}

std::array<double, 3> corner_shares(const Vector& y, const Vector& z, const Vector& place) {
  const Vector m = cross(y, z);
  const double square = dot(m, m);
  const double of_y = dot(cross(place, z), m) / square, of_z = dot(cross(y, place), m) / square;
  return {1.0 - of_y - of_z, of_y, of_z};
}

TriangleFrame triangle_frame(const LaneVector<Vector>& x, const Facet& facet) {
  const Vector &x1 = x[facet.node[0]], e2 = x[facet.node[1]] - x1, e3 = x[facet.node[2]] - x1;
  const double length = norm(e2);
  TriangleFrame f;
  f.s = e2 / length;
  f.n = normalized(cross(e2, e3));
  f.t = cross(f.n, f.s);
  const double x3 = dot(f.s, e3), y3 = dot(f.t, e3);
  f.gradient[1] = {1 / length, -x3 / (length * y3)};
  f.gradient[2] = {0, 1 / y3};
  for (size_t k = 0; k < 2; ++k) f.gradient[0][k] = -f.gradient[1][k] - f.gradient[2][k];
  return f;
}

void move_foot(Facet& facet, const ShapeGradients& gradient, double along_s, double along_t) {
  for (size_t k = 0; k < 3; ++k) facet.weight[k] += gradient[k][0] * along_s + gradient[k][1] * along_t;
}

void take_axes(Point& p, const TriangleFrame& frame) { p.n = frame.n, p.s = frame.s, p.t = frame.t; }

void take_back_facets(World& w) {
  for (const int c : w.chunks.own) {
    const Chunk& chunk = w.chunks.all[size_t(c)];
    Family& f = w.contacts.families[size_t(chunk.family)];
    for (const FacetLanes& lanes : chunk.facets) {
      for (size_t l = 0; l < lanes.count; ++l) {
        Facet& facet = w.contacts.facets[size_t(lanes.facet_a[l])];
        for (int k = 0; k < 3; ++k) facet.weight[k] = lanes.weight_a[k][l];
        if (!w.is_small) take_axes(f.point[lanes.first + l], triangle_frame(w.nodes.x, facet));
      }
    }
  }
}

Location locate(const World& w, const Point& p, const LaneVector<Facet>& facets) {
  Location l;
  if (p.facet_b >= 0) {
    const Facet& facet = facets[p.facet_b];
    l.at = facet.weight[0] * w.nodes.x[facet.node[0]] + facet.weight[1] * w.nodes.x[facet.node[1]] +
           facet.weight[2] * w.nodes.x[facet.node[2]];
  } else {
    const Body& b = w.bodies[w.blocks[p.b].body];
    l.at = b.x + b.r * p.arm;
  }
  if (p.facet_a >= 0) {
    const Facet& facet = facets[p.facet_a];
    Vector d = l.at - (facet.weight[0] * w.nodes.x[facet.node[0]] + facet.weight[1] * w.nodes.x[facet.node[1]] +
                       facet.weight[2] * w.nodes.x[facet.node[2]]);
    if (p.on_gridpoints) d = transposed_times(rotation_of_frame(w, p.a), d);
    l.jump = dot(p.n, d) - p.reference;
    l.slid[0] = dot(p.s, d), l.slid[1] = dot(p.t, d);
  } else {
    const Body& a = w.bodies[w.blocks[p.a].body];
    const Vector j = transposed_times(a.r, l.at - a.x);
    l.jump = dot(p.n, j) - p.offset;
    l.slid[0] = dot(p.s, j), l.slid[1] = dot(p.t, j);
  }
  return l;
}

void keep_opening(Point& p, double jump, double opening) {
  p.reference += jump - opening;
  if (p.facet_a < 0) p.offset += jump - opening;
}

std::pair<double, double> turned_into(const Vector& s, const Vector& t, const Vector& v) {
  const double along_s = dot(v, s), along_t = dot(v, t);
  const double size = std::sqrt(along_s * along_s + along_t * along_t), keep = size > 0 ? norm(v) / size : 1.0;
  return {keep * along_s, keep * along_t};
}

// Moves a point from its gridpoint on block a to a triangle. The foot moves below the point; joint vectors are turned
// into the axes of the triangle. The opening stays, and so does the slip since the last call of the law.
void leave_gridpoints(World& w, Family& f, size_t i) {
  Point& p = f.point[i];
  Facet& facet = w.contacts.facets[size_t(p.facet_a)];
  const Location before = locate(w, p, w.contacts.facets);
  const Matrix then = frame_of(w, p);
  p.on_gridpoints = false;
  const TriangleFrame frame = triangle_frame(w.nodes.x, facet);
  take_axes(p, frame);
  const auto turn = [&](const auto& then_s, const auto& then_t, auto& now_s, auto& now_t) {
    std::tie(now_s[i], now_t[i]) = turned_into(p.s, p.t, then_s[i] * then.row[1] + then_t[i] * then.row[2]);
  };
  turn_joint_vectors(f, f, turn);
  for (int k = 0; k < 2; ++k) f.slid[k][i] -= before.slid[k];
  turn(f.slid[0], f.slid[1], f.slid[0], f.slid[1]);
  const Location now = locate(w, p, w.contacts.facets);
  move_foot(facet, frame.gradient, now.slid[0], now.slid[1]);
  keep_opening(p, locate(w, p, w.contacts.facets).jump, before.jump);
}

}  // namespace quoin::blocks
