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
  double height = 0.0, shortest_edge = 0.0;  // m, the smallest ones
};
ZoneSize size_of_zone(const Zoning& zoning, const std::array<int, 4>& zone);

// The vertices of a six-sided block of brick topology. Number i of the result is at bits (x, y, z) of i, as in
// geometry::box, along the axes that divisions count. Nothing for other shapes.
std::optional<std::array<int, 8>> brick_corners(const ConvexPolyhedron& shape);

// Hexahedra along an edge of so many m, a whole number: one more only where it is longer by more than rounding.
double hexahedra_along(double length, double target_edge);

// Hexahedra along these axes with edges of at most `target_edge` (m), for shapes with brick_corners.
std::array<int, 3> brick_divisions(const ConvexPolyhedron& shape, double target_edge);

// Zones with edges of at most 1.5 times `target_edge` (m). Six-sided blocks of brick topology (bricks, voussoirs) in n
// x m x k hexahedra of 5 zones. Others in a fan about their centroid, whose long edges are halved; where edges are 12
// times the target, every zone is first cut in 8. Blocks that share a face share its triangles. Throws Error(bad_input)
// when the target is not positive or would give more than ten million zones.
Zoning make_zones(const ConvexPolyhedron& shape, double target_edge, const std::string& name);

// The same with given divisions for six-sided shapes: along the edges 0-1, 0-2, 0-4 of geometry::box. parity: which of
// the two 5-zone patterns the first hexahedron has.
Zoning make_brick_zones(const ConvexPolyhedron& shape, std::array<int, 3> divisions, int parity,
                        const std::string& name);

// Tetrahedra that were made elsewhere, and the convex body that they fill.
struct ZonedShape {
  ConvexPolyhedron shape;
  Zoning zoning;
};

// The body of tetrahedra that each name four of the points (m), with positive volume
// (p1 - p0) . ((p2 - p0) x (p3 - p0)) / 6. Throws Error(bad_input), with the number of the tetrahedron and its place:
// numbers without a point, points without a tetrahedron, flat and inverted ones. Also neighbours that do not share
// whole triangles; what overlaps, has holes or is not convex as a whole.
ZonedShape from_tetrahedra(const std::vector<Vector>& points, const std::vector<std::array<int, 4>>& tetrahedra,
                           const std::string& name);

}  // namespace quoin::geometry
