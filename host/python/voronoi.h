// Voronoi cells in a box, for stones of irregular shape.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <utility>
#include <vector>

namespace quoin::python {

// Voronoi cells of seeds (rows of x, y, z, m) in a box from the origin. Returns the corners of each convex cell, as
// rows, and the centroids of all cells. Throws Error(bad_input) for seeds outside of the box, or two at one place.
std::pair<std::vector<pybind11::array_t<double>>, pybind11::array_t<double>> voronoi(
    const pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>& seeds,
    const std::array<double, 3>& size);

}  // namespace quoin::python
