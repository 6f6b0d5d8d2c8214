// Convex polyhedra: construction from vertices or faces, validation, mass properties.
#pragma once

#include <string>
#include <vector>

#include "geometry/vector.h"

namespace quoin::geometry {

// Vertices in m. Faces are planar, with corners counter-clockwise seen from outside; neighbours are never coplanar.
// Edges are listed once, with their two faces.
struct ConvexPolyhedron {
  std::vector<Vector> vertices;
  std::vector<std::vector<int>> faces;
  std::vector<Vector> normals;  // outward, one a face
  struct Edge {
    int tail, head;   // in the direction of the corners of `left`
    int left, right;  // faces
  };
  std::vector<Edge> edges;
};

// Largest distance of a vertex from its face, or in front of another face, relative to the largest extent of the block.
// Larger distances are errors. Mesh files in single precision need 1e-6.
constexpr double shape_tolerance = 1e-6;

// Convex hull of points; points inside it are dropped. name: for messages. relative_tolerance: tolerance over the
// largest extent; a face includes corners within twice that distance of its plane. Throws Error(bad_input) for fewer
// than four points, numbers that are not finite, and flat or needle-like sets of points.
ConvexPolyhedron from_vertices(const std::vector<Vector>& points, const std::string& name,
                               double relative_tolerance = shape_tolerance);

// A closed convex surface by its faces, counter-clockwise seen from outside. Coplanar neighbours, as in mesh files, are
// merged. Throws Error(bad_input) with block, face, place and distance. Errors are corner numbers out of range, holes,
// inverted faces, faces that are not planar, zero volume, and non-convex shapes.
ConvexPolyhedron from_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                            const std::string& name);

// Checks of from_faces. check_closed throws Error(bad_input) for corner numbers out of range, holes, inverted faces or
// bodies, and zero volume. fault_of_faces describes the first face that is not planar or has a vertex in front of it;
// empty: none.
void check_closed(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces,
                  const std::string& name);
std::string fault_of_faces(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces);
constexpr const char* how_to_cut =
    "cut it into convex parts where it was drawn, give them one `unit`, and join them by a joint_rule with "
    "inside_units "
    "of an elastic family";

// Volume of a closed surface, m3.
double volume_within(const std::vector<Vector>& vertices, const std::vector<std::vector<int>>& faces);

// Plane through the mean of a face's corners, normal to its vector area.
struct Plane {
  Vector centre, normal;  // normal: unit, outward; zero for a face without area
};
Plane plane_of(const std::vector<Vector>& vertices, const std::vector<int>& face);

ConvexPolyhedron box(const Vector& lower, const Vector& size);

// Sets normals and edges from vertices and faces.
void complete(ConvexPolyhedron& shape);
// Computes the normals of the same faces after the vertices have moved.
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
double least_extent(const ConvexPolyhedron& shape);        // least distance between a face and a parallel plane, m
std::string place(const Vector& p);                        // "(1.2, 0.4, 0) m", for messages

}  // namespace quoin::geometry
