// Convex polyhedra: construction from vertices or faces, validation, mass properties.
#pragma once

#include <string>
#include <vector>

#include "geometry/vector.h"

namespace quoin::geometry {

// Vertices in m; faces are planar, with corners counter-clockwise seen from outside, neighbours never coplanar.
// Edges are listed once, with the two faces they part.
struct ConvexPolyhedron {
  std::vector<Vector> vertices;
  std::vector<std::vector<int>> faces;
  std::vector<Vector> normals;  // outward, one a face
  struct Edge {
    int tail, head;   // in the direction in which `left` runs
    int left, right;  // faces
  };
  std::vector<Edge> edges;
};

// Relative to the largest extent of a block: how far a vertex may lie off its face, or in front of another face,
// before the input is refused. Mesh files in single precision need 1e-6.
constexpr double shape_tolerance = 1e-6;

// The hull of points; points inside it are dropped. `name` stands in the messages. Throws Error(bad_input): fewer than
// four points, not a number, flat or needle-like point sets.
ConvexPolyhedron from_vertices(const std::vector<Vector>& points, const std::string& name);

// A closed convex surface given by faces (counter-clockwise seen from outside; neighbouring coplanar faces, as mesh
// files have them, are merged). Throws Error(bad_input) naming block, face, place and distance: corner numbers out of
// range, holes, inverted faces, faces that are not planar, zero volume, non-convex.
ConvexPolyhedron from_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                            const std::string& name);

ConvexPolyhedron box(const Vector& lower, const Vector& size);

// Sets normals and edges from vertices and faces.
void complete(ConvexPolyhedron& shape);
// Normals of the same faces after the vertices have moved.
void update_normals(ConvexPolyhedron& shape);

struct MassProperties {
  double volume = 0.0;              // m3
  Vector centroid;                  // m
  Matrix inertia = Matrix::zero();  // per unit density, about the centroid, m5
};
MassProperties mass_properties(const ConvexPolyhedron& shape);

double face_area(const ConvexPolyhedron& shape, int face);  // m2
Vector face_centroid(const ConvexPolyhedron& shape, int face);
double longest_extent(const std::vector<Vector>& points);  // of the bounding box, m
std::string place(const Vector& p);                        // "(1.2, 0.4, 0) m" for messages

}  // namespace quoin::geometry
