// Tetrahedral zoning of convex polyhedra.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "geometry/polyhedron.h"

namespace quoin::geometry {

struct Zoning {
  std::vector<Vector> nodes;              // gridpoints, m; the first ones are the vertices of the shape, in order
  std::vector<std::array<int, 4>> zones;  // positive volume
  struct SurfaceTriangle {
    std::array<int, 3> node;  // counter-clockwise seen from outside
    int face;                 // face of the shape
  };
  std::vector<SurfaceTriangle> surface;
  double longest_edge = 0.0;  // m
  // Mean-ratio quality 12 (3 V)^(2/3) / sum of squared edges: 1 for the regular tetrahedron, 0 for a flat one.
  double worst_quality = 1.0, mean_quality = 1.0;
};

struct ZoneSize {
  double height = 0.0, shortest_edge = 0.0;  // smallest ones, m
};
ZoneSize size_of_zone(const Zoning& zoning, const std::array<int, 4>& zone);

// The vertices of a six-sided block of brick topology. Number i of the result is at bits (x, y, z) of i, as in
// geometry::box, along the axes of the divisions. Nothing for other shapes.
std::optional<std::array<int, 8>> brick_corners(const ConvexPolyhedron& shape);

// Number of hexahedra along an edge of this length, m; lengths beyond a multiple of the target by rounding do not add
// one.
double hexahedra_along(double length, double target_edge);

// Hexahedra along the axes of brick_corners, with edges of at most `target_edge` (m).
std::array<int, 3> brick_divisions(const ConvexPolyhedron& shape, double target_edge);

// Zones with edges of at most 1.5 times `target_edge` (m). Six-sided blocks of brick topology (bricks, voussoirs) have
// n x m x k hexahedra of 5 zones. Others have a fan about their centroid, whose long edges are halved. Where edges
// exceed 12 times the target, every zone is first divided into 8. Blocks that share a face share its triangles. Throws
// Error(bad_input) when the target is not positive or would give more than ten million zones.
Zoning make_zones(const ConvexPolyhedron& shape, double target_edge, const std::string& name);

// Zones of six-sided shapes with given divisions along the edges 0-1, 0-2, 0-4 of geometry::box. parity: which of the
// two 5-zone patterns the first hexahedron has.
Zoning make_brick_zones(const ConvexPolyhedron& shape, std::array<int, 3> divisions, int parity,
                        const std::string& name);

// Given tetrahedra, and the convex body that they fill.
struct ZonedShape {
  ConvexPolyhedron shape;
  Zoning zoning;
};

// The body of tetrahedra that each have four of the points (m), with positive volume (p1 - p0) . ((p2 - p0) x (p3 -
// p0)) / 6. Throws Error(bad_input) with the number of the tetrahedron and its place. Errors are numbers without a
// point, points without a tetrahedron, flat and inverted tetrahedra, and neighbours that do not share whole triangles.
// Overlaps, holes and bodies that are not convex are errors too.
ZonedShape from_tetrahedra(const std::vector<Vector>& points, const std::vector<std::array<int, 4>>& tetrahedra,
                           const std::string& name);

}  // namespace quoin::geometry
