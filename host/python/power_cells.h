// Cells of a power diagram of seeds in a box (Voro++).
#pragma once

#include <optional>
#include <vector>

#include "geometry/vector.h"

namespace quoin::python {

// Faces go round their corners; neighbours of faces are cells, or walls of the box: -1 low x, -2 high x, -3 low y ...
struct Cell {
  std::vector<geometry::Vector> corners;  // m
  std::vector<std::vector<int>> faces;
  std::vector<int> neighbours;
  geometry::Vector centroid;
};

// Where |x - p|^2 - w is less for a seed p of weight w than for any other one. All weights 0: Voronoi's.
struct PowerDiagram {
  std::vector<geometry::Vector> seeds;  // m
  std::vector<double> weights;          // m2
  geometry::Vector size;                // size of the box from the origin, m

  // By seeds. None where one has no cell.
  std::optional<std::vector<Cell>> cells() const;
};

}  // namespace quoin::python
