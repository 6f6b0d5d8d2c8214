// Contact or gap of two convex polyhedra, by the separating axis of greatest separation: the normal of 3DEC's common
// plane. Candidates are the face normals of both and the cross products of their edges.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "geometry/polyhedron.h"

namespace quoin::geometry {

// A polyhedron in space: the topology of a shape with current vertices and normals.
struct Placed {
  const ConvexPolyhedron* shape;
  const Vector* vertices;  // m
  const Vector* normals;   // outward
  Vector centre;           // any inner point, m
  bool is_bent = false;    // whether its faces may be bent under load, as those of deformable blocks
};
inline Placed placed(const ConvexPolyhedron& s, const Vector& centre) {
  return {&s, s.vertices.data(), s.normals.data(), centre};
}

struct Separation {
  enum Feature : std::int64_t { none = 0, face_of_a = 1, face_of_b = 2, edges = 3 };
  Feature feature = none;
  int index_a = -1, index_b = -1;  // face or edge; -1 for the body without a face in it
  double distance = 0.0;           // along the normal, m; > 0 apart, < 0 overlapping
  Vector normal;                   // unit, from a to b
};

// `previous` (same pair, an earlier time) is tried first. If it still separates by more than `stop_beyond`, no other
// axis is tried. Among axes that agree within `preference` (m), the feature of `previous` is kept, then faces precede
// edges, so that the reference does not alternate. A positive distance is a lower bound of the true distance.
Separation separate(const Placed& a, const Placed& b, double stop_beyond, double preference,
                    const Separation* previous = nullptr);

// Face of p whose outward normal is closest to `direction`.
int facing(const Placed& p, const Vector& direction);

// Points of two edges, p to p + u and q to q + v, at which their lines are closest. None where such a point is beyond
// the end of an edge, as for almost parallel edges.
std::optional<std::pair<Vector, Vector>> crossing_points(const Vector& p, const Vector& u, const Vector& q,
                                                         const Vector& v);

}  // namespace quoin::geometry
