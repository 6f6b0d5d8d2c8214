#include "geometry/separation.h"

#include <algorithm>
#include <vector>

namespace quoin::geometry {
namespace {

// Least signed distance of the vertices of `other` in front of the plane of a face.
double face_distance(const Placed& p, int face, const Placed& other) {
  const Vector n = p.normals[face];
  const double offset = dot(n, p.vertices[p.shape->faces[face][0]]);
  double least = 1e300;
  const size_t count = other.shape->vertices.size();
  for (size_t i = 0; i < count; ++i) least = std::min(least, dot(n, other.vertices[i]));
  return least - offset;
}

struct Edge {
  Vector point, direction;
  Vector left, right;  // normals of its faces
  Vector across;       // right x left
  int index;
};
Edge edge(const Placed& p, int i) {
  const auto& e = p.shape->edges[i];
  const Vector left = p.normals[e.left], right = p.normals[e.right];
  return {p.vertices[e.tail], p.vertices[e.head] - p.vertices[e.tail], left, right, cross(right, left), i};
}

// Whether the edges span a face of the Minkowski difference (arcs of their normals cross on the Gauss sphere). Only
// such pairs can give the greatest separation.
bool arcs_cross(const Edge& a, const Edge& b) {
  const double cba = -dot(b.left, a.across), dba = -dot(b.right, a.across);
  if (!(cba * dba < 0)) return false;
  const double adc = dot(a.left, b.across), bdc = dot(a.right, b.across);
  return adc * bdc < 0 && cba * bdc > 0;
}

// Whether no axis on the arc between the normals of an edge's faces separates the bodies by more than `distance`.
// One vertex of the other body shows it, d from the edge, by the largest n . d on the arc. That is |d| across the edge
// where d points into the arc. Else it is the larger of u and v, at the ends of the arc.
bool cannot_separate(const Edge& e, const Placed& other, double distance) {
  const double cosine = dot(e.left, e.right);
  const double square = distance > 0 ? distance * distance * (1 - cosine * cosine) : -1.0;
  for (size_t i = 0; i < other.shape->vertices.size(); ++i) {
    const Vector d = other.vertices[i] - e.point;
    const double u = dot(e.left, d), v = dot(e.right, d);
    const bool on_arc = u >= cosine * v && v >= cosine * u;
    if (on_arc ? u * u + v * v - 2 * cosine * u * v <= square : std::max(u, v) <= distance) return true;
  }
  return false;
}

// Edges that may separate the bodies by more than `distance`. With bent faces the normal of two edges lies beside the
// arcs, so all of them may.
void list_edges(const Placed& p, const Placed& other, double distance, std::vector<Edge>& edges) {
  const bool all = p.is_bent || other.is_bent;
  edges.clear();
  for (size_t i = 0; i < p.shape->edges.size(); ++i) {
    const Edge e = edge(p, int(i));
    if (all || !cannot_separate(e, other, distance)) edges.push_back(e);
  }
}

bool edge_axis(const Placed& a, const Placed& b, const Edge& ea, const Edge& eb, Separation& s) {
  const Vector m = cross(ea.direction, eb.direction);
  const double sine2 = dot(m, m), scale2 = dot(ea.direction, ea.direction) * dot(eb.direction, eb.direction);
  if (sine2 < 1e-6 * scale2) return false;  // parallel: a face normal gives the same axis
  s.normal = m / std::sqrt(sine2);
  if (dot(s.normal, ea.point - a.centre) < 0) s.normal = -s.normal;
  // Extents of all corners, not of the edges, since arcs of faces that are bent under load may seem to cross where they
  // do not.
  double lowest = 1e300, highest = -1e300;
  for (size_t i = 0; i < b.shape->vertices.size(); ++i) lowest = std::min(lowest, dot(s.normal, b.vertices[i]));
  for (size_t i = 0; i < a.shape->vertices.size(); ++i) highest = std::max(highest, dot(s.normal, a.vertices[i]));
  s.distance = lowest - highest;
  s.feature = Separation::edges;
  return true;
}

}  // namespace

int facing(const Placed& p, const Vector& direction) {
  int best = 0;
  for (size_t f = 1; f < p.shape->faces.size(); ++f) {
    // The margin keeps the choice among parallel candidates independent of rounding.
    if (dot(p.normals[f], direction) > dot(p.normals[best], direction) + 1e-9) best = int(f);
  }
  return best;
}

Separation separate(const Placed& a, const Placed& b, double stop_beyond, double preference,
                    const Separation* previous) {
  Separation kept;
  kept.distance = -1e300;
  if (previous != nullptr && previous->feature != Separation::none) {
    kept = *previous;
    if (kept.feature == Separation::face_of_a) {
      kept.distance = face_distance(a, kept.index_a, b);
      kept.normal = a.normals[kept.index_a];
    } else if (kept.feature == Separation::face_of_b) {
      kept.distance = face_distance(b, kept.index_b, a);
      kept.normal = -b.normals[kept.index_b];
    } else {
      const Edge ea = edge(a, kept.index_a), eb = edge(b, kept.index_b);
      if (!arcs_cross(ea, eb) || !edge_axis(a, b, ea, eb, kept))
        kept.distance = -1e300, kept.feature = Separation::none;
    }
    if (kept.distance > stop_beyond) return kept;
  }
  Separation best;
  best.distance = -1e300;
  for (size_t f = 0; f < a.shape->faces.size(); ++f) {
    const double d = face_distance(a, int(f), b);
    if (d > best.distance) best = {Separation::face_of_a, int(f), -1, d, a.normals[f]};
    if (d > stop_beyond) return best;
  }
  for (size_t f = 0; f < b.shape->faces.size(); ++f) {
    const double d = face_distance(b, int(f), a);
    const bool other_body = best.feature == Separation::face_of_a;
    if (d > best.distance + (other_body ? preference : 0.0))
      best = {Separation::face_of_b, -1, int(f), d, -b.normals[f]};
    if (d > stop_beyond) return best;
  }
  Separation crossing;
  crossing.distance = best.distance + preference;
  bool found = false;
  thread_local std::vector<Edge> of_a, of_b;
  list_edges(a, b, crossing.distance, of_a);
  if (!of_a.empty()) list_edges(b, a, crossing.distance, of_b);
  for (const Edge& ea : of_a) {
    for (const Edge& eb : of_b) {
      if (!arcs_cross(ea, eb)) continue;
      Separation s;
      if (!edge_axis(a, b, ea, eb, s) || s.distance <= crossing.distance) continue;
      s.index_a = ea.index, s.index_b = eb.index;
      crossing = s;
      found = true;
      if (s.distance > stop_beyond) return s;
    }
  }
  if (found) best = crossing;
  if (kept.feature != Separation::none && kept.distance >= best.distance - preference) return kept;
  return best;
}

std::optional<std::pair<Vector, Vector>> crossing_points(const Vector& p, const Vector& u, const Vector& q,
                                                         const Vector& v) {
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), det = uu * vv - uv * uv;
  const Vector w = q - p;
  const double a = (dot(w, u) * vv - dot(w, v) * uv) / det, b = (dot(w, u) * uv - dot(w, v) * uu) / det;
  if (!(a >= 0 && a <= 1 && b >= 0 && b <= 1)) return std::nullopt;  // not a number for parallel lines
  return std::pair{p + a * u, q + b * v};
}

}  // namespace quoin::geometry
