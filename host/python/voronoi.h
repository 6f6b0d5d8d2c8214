// Cells of a box around seeds, for stones of irregular shape.
#pragma once

#include <pybind11/numpy.h>

#include <array>
#include <utility>
#include <vector>

namespace quoin::python {

// The part of a box from the origin that is nearer to a seed than to any other one. For each seed (a row of three, m)
// the corners of its convex cell, a row of three each; and the centroids of all. Throws Error(bad_input): seeds that
// are not inside the box, or two at the same place.
std::pair<std::vector<pybind11::array_t<double>>, pybind11::array_t<double>> voronoi(
    const pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>& seeds,
    const std::array<double, 3>& size);

}  // namespace quoin::python
