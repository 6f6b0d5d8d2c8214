// Cyclic paths of opening, sliding in two directions and pressure, a different one for every point, for joints of
// mortar.h. For tests and benchmarks of convergence.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

namespace quoin::test::mixed {

inline constexpr std::size_t kPoints = 256;

struct Jump {
  double n, s, t;  // m
};

// Returns six random numbers of a point, in [0, 1).
inline const std::array<double, 6>& numbers(std::size_t point) {
  static const std::vector<std::array<double, 6>> all = [] {
    std::mt19937_64 random(20261121);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    std::vector<std::array<double, 6>> drawn(kPoints);
    for (auto& of_point : drawn) std::generate(of_point.begin(), of_point.end(), [&] { return unit(random); });
    return drawn;
  }();
  return all[point];
}

// Returns the jumps at x, 0 to 1: pressure, then opening to a third of the ultimate 150 um and closing, growing from
// cycle to cycle. Sliding is cyclic along both axes, to half of the ultimate 830 um. wider: share by which openings are
// larger.
inline Jump path(std::size_t point, double x, double wider = 0.0) {
  const auto& r = numbers(point);
  const double turn = 2.0 * std::numbers::pi * x;
  const double opening = (1.0 + wider) * (1e-5 + 4e-5 * r[1]) * x * (1.0 - std::cos((2.0 + 2.0 * r[2]) * turn));
  const double sliding = 4e-4 * r[3] * x;
  return {-1.5e-5 * r[0] * std::min(1.0, 20.0 * x) + opening, sliding * std::sin((2.0 + 3.0 * r[4]) * turn),
          0.5 * sliding * std::sin((1.0 + 3.0 * r[5]) * turn)};
}
// Returns the jumps of `path`, with closures beyond the peak at 90 um between the openings.
inline Jump crushing_path(std::size_t point, double x) {
  const auto& r = numbers(point);
  const double turn = 2.0 * std::numbers::pi * x;
  Jump d = path(point, x);
  d.n -= (5e-5 + 2e-4 * r[4]) * x * (1.0 + std::cos((2.0 + 2.0 * r[2]) * turn));
  return d;
}

}  // namespace quoin::test::mixed
