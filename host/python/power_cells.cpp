#include "python/power_cells.h"

#include <algorithm>
#include <cmath>
#include <voro++/voro++.hh>

namespace quoin::python {

using geometry::Vector;

std::optional<std::vector<Cell>> PowerDiagram::cells() const {
  constexpr double kSeedsOfGridBox = 5.0;  // seeds per box of the grid for which Voro++ is fastest
  const auto count = static_cast<int>(seeds.size());
  const double spacing = std::cbrt(size.x * size.y * size.z * kSeedsOfGridBox / count);
  const auto boxes = [&](double length) { return static_cast<int>(std::clamp(length / spacing, 1.0, 1000.0)); };
  voro::container_poly box(0.0, size.x, 0.0, size.y, 0.0, size.z, boxes(size.x), boxes(size.y), boxes(size.z), false,
                           false, false, 8);
  const double least = *std::min_element(weights.begin(), weights.end());
  for (int i = 0; i < count; ++i) {
    const Vector& p = seeds[static_cast<std::size_t>(i)];
    box.put(i, p.x, p.y, p.z, std::sqrt(weights[static_cast<std::size_t>(i)] - least));
  }
  std::vector<Cell> made(seeds.size());
  std::size_t found = 0;
  voro::c_loop_all seed(box);
  voro::voronoicell_neighbor cell;
  if (seed.start()) do {
      if (!box.compute_cell(cell, seed)) continue;
      double x = 0.0, y = 0.0, z = 0.0;
      seed.pos(x, y, z);
      Cell& own = made[static_cast<std::size_t>(seed.pid())];
      std::vector<double> xyz;
      cell.vertices(x, y, z, xyz);
      for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) own.corners.push_back({xyz[i], xyz[i + 1], xyz[i + 2]});
      std::vector<int> loops;
      cell.face_vertices(loops);
      for (std::size_t i = 0; i < loops.size(); i += static_cast<std::size_t>(loops[i]) + 1)
        own.faces.emplace_back(loops.begin() + static_cast<long>(i) + 1,
                               loops.begin() + static_cast<long>(i) + 1 + loops[i]);
      cell.neighbors(own.neighbours);
      Vector& c = own.centroid;
      cell.centroid(c.x, c.y, c.z);
      c += Vector{x, y, z};
      ++found;
    } while (seed.inc());
  if (found < made.size()) return std::nullopt;
  return made;
}

}  // namespace quoin::python
