// Overlap of two faces projected onto their common plane, and quadrature points on it.
#pragma once

#include <vector>

#include "geometry/vector.h"

namespace quoin::geometry {

struct Point2 {
  double x, y;
};
using Polygon = std::vector<Point2>;  // convex, counter-clockwise

double area(const Polygon& polygon);
Point2 centroid(const Polygon& polygon);

// Part of the convex polygon `subject` inside the convex polygon `window`, in `result`; empty without overlap. Corners
// closer than `tolerance` (m) are merged. `scratch` avoids allocations.
void clip(const Polygon& subject, const Polygon& window, double tolerance, Polygon& result, Polygon& scratch);

// A point and its share of the area.
struct QuadraturePoint {
  Point2 at;
  double area;  // m2
};

// Quadrature rules have positive weights with the area as their sum. They are exact for linear functions, so constant
// stress gives the right force and moment (patch test). Points at the corners let a rocking block turn about its true
// edge.
// - vertex_rule: corners only, by the integrals of Wachspress' coordinates; a quarter of the area each for a rectangle,
//   a third for a triangle. A corner that goes flat loses its area, so the rule changes with the overlap without a
//   jump.
// - cubic_rule: fan about the centroid, 7 points a triangle (corners 1/20, mid-sides 2/15, centre 9/20). It is exact
//   for cubics, and so is the rotational stiffness of an elastic joint.
// - grid_rule: vertex rule on cells no longer than `spacing`, for stress profiles inside one joint. Quadrilaterals are
//   divided like a brick's face, other polygons in a fan.
void vertex_rule(const Polygon& polygon, std::vector<QuadraturePoint>& points);
void cubic_rule(const Polygon& polygon, std::vector<QuadraturePoint>& points);
void grid_rule(const Polygon& polygon, double spacing, std::vector<QuadraturePoint>& points);

// Adds a point, or adds its area to a point within `tolerance` (from index `first` on); returns the index of the point.
size_t add_merged(std::vector<QuadraturePoint>& points, size_t first, const QuadraturePoint& p, double tolerance);

}  // namespace quoin::geometry
