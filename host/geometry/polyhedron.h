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

// How far a vertex may lie off its face, or in front of another face, relative to the largest extent of the block.
// Beyond it the input is refused. Mesh files in single precision need 1e-6.
constexpr double shape_tolerance = 1e-6;

// The hull of points; points inside it are dropped. `name` stands in the messages. relative_tolerance: of the largest
// extent; faces take in corners that lie off their planes by twice that. Throws Error(bad_input): fewer than four
// points, not a number, flat or needle-like point sets.
ConvexPolyhedron from_vertices(const std::vector<Vector>& points, const std::string& name,
                               double relative_tolerance = shape_tolerance);

// A closed convex surface given by faces (counter-clockwise seen from outside; neighbouring coplanar faces, as mesh
// files have them, are merged). Throws Error(bad_input) naming block, face, place and distance: corner numbers out of
// range, holes, inverted faces, faces that are not planar, zero volume, non-convex.
ConvexPolyhedron from_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                            const std::string& name);

// The checks of from_faces. check_closed throws Error(bad_input) for corner numbers out of range, holes, faces or
// bodies that are inverted, zero volume. fault_of_faces: the first face that is not planar or has a vertex in front of
// it, in words; empty: there is none.
void check_closed(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                  const std::string& name);
std::string fault_of_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces);
constexpr const char* how_to_cut =
    "cut it into convex parts where it was drawn, give them one `unit`, and join them by a joint_rule with "
    "inside_units "
    "of an elastic family";

// m3, of a closed surface.
double volume_within(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces);

// The plane through the mean of a face's corners, normal to its vector area.
struct Plane {
  Vector centre, normal;  // normal: unit, outward; zero for a face without area
};
Plane plane_of(const std::vector<Vector>& vertices, const std::vector<int>& face);

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
double longest_extent(const std::vector<Vector>& points);  // longest side of the bounding box, m
std::string place(const Vector& p);                        // "(1.2, 0.4, 0) m" for messages

}  // namespace quoin::geometry
