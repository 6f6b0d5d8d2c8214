#include "python/voronoi.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <voro++/voro++.hh>

#include "base/error.h"

namespace quoin::python {

namespace py = pybind11;

std::pair<std::vector<py::array_t<double>>, py::array_t<double>> voronoi(
    const py::array_t<double, py::array::c_style | py::array::forcecast>& seeds, const std::array<double, 3>& size) {
  constexpr double kSeedsOfGridBox = 5.0;  // Voro++ is fastest with about so many
  if (seeds.ndim() != 2 || seeds.shape(1) != 3 || seeds.shape(0) < 1)
    throw Error(Exit::bad_input, "seeds: an array of rows of three numbers is needed");
  if (!std::all_of(size.begin(), size.end(), [](double s) { return s > 0.0 && std::isfinite(s); }))
    throw Error(Exit::bad_input, "size: three numbers of more than 0 are needed, m");
  const auto count = static_cast<int>(seeds.shape(0));
  const double spacing = std::cbrt(size[0] * size[1] * size[2] * kSeedsOfGridBox / count);
  std::array<int, 3> grid{};
  for (std::size_t k = 0; k < 3; ++k) grid[k] = static_cast<int>(std::clamp(size[k] / spacing, 1.0, 1000.0));
  voro::container box(0.0, size[0], 0.0, size[1], 0.0, size[2], grid[0], grid[1], grid[2], false, false, false, 8);
  const auto rows = seeds.unchecked<2>();
  for (int i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = rows(i, static_cast<py::ssize_t>(k));
      if (!(at > 0.0 && at < size[k]))
        throw Error(Exit::bad_input, fmt::format("seed {}: {} is not inside the box, 0 to {} m", i, at, size[k]));
    }
    box.put(i, rows(i, 0), rows(i, 1), rows(i, 2));
  }
  py::array_t<double> centroids(std::array<py::ssize_t, 2>{count, 3});
  auto middle = centroids.mutable_unchecked<2>();
  std::vector<py::array_t<double>> cells(static_cast<std::size_t>(count));
  std::size_t found = 0;
  voro::c_loop_all seed(box);
  voro::voronoicell cell;
  if (seed.start()) do {
      if (!box.compute_cell(cell, seed)) continue;
      double x = 0.0, y = 0.0, z = 0.0;
      seed.pos(x, y, z);
      std::vector<double> corners;
      cell.vertices(x, y, z, corners);
      const std::array<py::ssize_t, 2> shape{static_cast<py::ssize_t>(corners.size() / 3), 3};
      cells[static_cast<std::size_t>(seed.pid())] = py::array_t<double>(shape, corners.data());
      double cx = 0.0, cy = 0.0, cz = 0.0;
      cell.centroid(cx, cy, cz);
      middle(seed.pid(), 0) = x + cx, middle(seed.pid(), 1) = y + cy, middle(seed.pid(), 2) = z + cz;
      ++found;
    } while (seed.inc());
  if (found < cells.size())
    throw Error(Exit::bad_input, fmt::format("{} of {} seeds have no cell: are two of them at the same place?",
                                             cells.size() - found, cells.size()));
  return {cells, centroids};
}

}  // namespace quoin::python
