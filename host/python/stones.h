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

// Cells of seeds in a box from the origin, as in voronoi.h, without edges shorter than `shortest`, whose ends become
// one corner. Cells are those of a power diagram, |x - p|^2 - w, with seeds p and weights w, initially 0. The smallest
// change of these is found for which the cells at both ends of such an edge meet in one point. So faces are planes
// shared by neighbours, stones are convex, and none is lost. Where there is no solution, short edges remain
// (shortest_edge). Throws Error(bad_input) for seeds without a cell.
Stones stones(std::vector<geometry::Vector> seeds, const geometry::Vector& size, double shortest);

}  // namespace quoin::python
