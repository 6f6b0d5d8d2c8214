// Convex stones that fill a box without short edges.
#pragma once

#include <array>
#include <vector>

#include "geometry/vector.h"

namespace quoin::python {

// Corners of each stone, and the shortest edge of all.
struct Stones {
  std::vector<std::vector<geometry::Vector>> corners;
  double shortest_edge = 0.0;
};

// The cells of seeds in a box from the origin, as by voronoi.h, whose edges shorter than `shortest` are gone. Their
// ends are one corner. Cells are those of a power diagram, |x - p|^2 - w, with seeds p and weights w, 0 at first. These
// are moved as little as possible, until the cells at both ends of such an edge meet in one point. So faces stay planes
// that neighbours share, stones stay convex, and none is lost. Where that does not succeed, short edges are left
// (shortest_edge). Throws Error(bad_input) for seeds without a cell.
Stones stones(std::vector<geometry::Vector> seeds, const geometry::Vector& size, double shortest);

}  // namespace quoin::python
