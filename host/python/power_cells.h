// Cells of a power diagram of seeds in a box, by Voro++.
#pragma once

#include <optional>
#include <vector>

#include "geometry/vector.h"

namespace quoin::python {

// Faces are loops of corners. Neighbours of faces are cells, or walls of the box: -1 low x, -2 high x, -3 low y ...
struct Cell {
  std::vector<geometry::Vector> corners;  // m
  std::vector<std::vector<int>> faces;
  std::vector<int> neighbours;
  geometry::Vector centroid;
};

// Cells of points x where |x - p|^2 - w is smaller for a seed p of weight w than for all others. With weights 0 they
// are Voronoi cells.
struct PowerDiagram {
  std::vector<geometry::Vector> seeds;  // m
  std::vector<double> weights;          // m2
  geometry::Vector size;                // size of the box from the origin, m

  // Cells in the order of seeds. None if a seed has no cell.
  std::optional<std::vector<Cell>> cells() const;
};

}  // namespace quoin::python
