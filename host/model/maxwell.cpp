#include "model/maxwell.h"

#include <cmath>
#include <numbers>

namespace quoin {

namespace {

constexpr int kCount = kMaxwellElements;
using Row = std::array<double, kCount>;

// Solves a x = b for symmetric positive definite a: elimination needs no pivots.
Row solved(std::array<Row, kCount> a, Row b) {
  for (std::size_t i = 0; i < kCount; ++i) {
    for (std::size_t r = i + 1; r < kCount; ++r) {
      const double factor = a[r][i] / a[i][i];
      for (std::size_t c = i; c < kCount; ++c) a[r][c] -= factor * a[i][c];
      b[r] -= factor * b[i];
    }
  }
  Row x{};
  for (std::size_t i = kCount; i-- > 0;) {
    double rest = b[i];
    for (std::size_t c = i + 1; c < kCount; ++c) rest -= a[i][c] * x[c];
    x[i] = rest / a[i][i];
  }
  return x;
}

}  // namespace

std::array<MaxwellElement, kCount> maxwell_elements(double damping_ratio, std::array<double, 2> band_Hz) {
  constexpr int kSamples = 101;  // sampled frequencies in the band, evenly over the logarithm
  std::array<MaxwellElement, kCount> elements{};
  if (damping_ratio <= 0.0) return elements;
  const auto at = [&](double way) {
    return 2.0 * std::numbers::pi * band_Hz[0] * std::pow(band_Hz[1] / band_Hz[0], way);
  };
  for (int e = 0; e < kCount; ++e) elements[static_cast<std::size_t>(e)].rate = at(e / (kCount - 1.0));
  // K'' = 2 ratio K' is linear in the shares, which makes the fit a linear least-squares problem.
  std::array<Row, kCount> normal{};
  Row right{};
  for (int i = 0; i < kSamples; ++i) {
    Row row{};
    for (std::size_t e = 0; e < kCount; ++e) {
      const double x = at(i / (kSamples - 1.0)) / elements[e].rate;
      row[e] = (x / (2.0 * damping_ratio) - x * x) / (1.0 + x * x);
    }
    for (std::size_t r = 0; r < kCount; ++r) {
      right[r] += row[r];
      for (std::size_t c = 0; c < kCount; ++c) normal[r][c] += row[r] * row[c];
    }
  }
  const Row shares = solved(normal, right);
  for (std::size_t e = 0; e < kCount; ++e) elements[e].share = shares[e];
  return elements;
}

}  // namespace quoin
