#include "python/voronoi.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "python/power_cells.h"

namespace quoin::python {

namespace py = pybind11;

std::pair<std::vector<py::array_t<double>>, py::array_t<double>> voronoi(
    const py::array_t<double, py::array::c_style | py::array::forcecast>& seeds, const std::array<double, 3>& size) {
  if (seeds.ndim() != 2 || seeds.shape(1) != 3 || seeds.shape(0) < 1)
    throw Error(Exit::bad_input, "seeds: an array of rows of three numbers is needed");
  if (!std::all_of(size.begin(), size.end(), [](double s) { return s > 0.0 && std::isfinite(s); }))
    throw Error(Exit::bad_input, "size: three numbers of more than 0 are needed, m");
  const py::ssize_t count = seeds.shape(0);
  PowerDiagram diagram{{}, std::vector<double>(static_cast<std::size_t>(count)), geometry::vector(size)};
  const auto rows = seeds.unchecked<2>();
  for (py::ssize_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double at = rows(i, static_cast<py::ssize_t>(k));
      if (!(at > 0.0 && at < size[k]))
        throw Error(Exit::bad_input, fmt::format("seed {}: {} is not inside the box, 0 to {} m", i, at, size[k]));
    }
    diagram.seeds.push_back({rows(i, 0), rows(i, 1), rows(i, 2)});
  }
  const auto cells = diagram.cells();
  if (!cells) throw Error(Exit::bad_input, "some seeds have no cell: are two of them at the same place?");
  py::array_t<double> centroids(std::array<py::ssize_t, 2>{count, 3});
  auto middle = centroids.mutable_unchecked<2>();
  std::vector<py::array_t<double>> corners;
  for (py::ssize_t i = 0; i < count; ++i) {
    const Cell& cell = (*cells)[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) middle(i, k) = cell.centroid[k];
    const std::array<py::ssize_t, 2> shape{static_cast<py::ssize_t>(cell.corners.size()), 3};
    auto own = corners.emplace_back(shape).mutable_unchecked<2>();
    for (py::ssize_t c = 0; c < shape[0]; ++c) {
      for (int k = 0; k < 3; ++k) own(c, k) = cell.corners[static_cast<std::size_t>(c)][k];
    }
  }
  return {corners, centroids};
}

}  // namespace quoin::python
