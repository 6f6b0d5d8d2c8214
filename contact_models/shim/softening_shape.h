// The softening function f(xi) of laws with fracture energies: its shape and its numbers.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

namespace quoin::shim {

enum class Shape : std::uint8_t { linear, exponential, table };

// Softening by points: f falls linearly from (x[k], f[k]) to (x[k+1], f[k+1]); f[0] = 1, f[last] = 0.
struct SofteningTable {
  static constexpr int kMaxPoints = 32;
  int points = 0;
  std::array<double, kMaxPoints> x{}, f{};
  std::array<double, kMaxPoints> area{};  // integral of f from 0 to x[k]
};

// End of exponential softening: from this xi on exp(-xi) is 0 in double precision.
inline constexpr double kExponentialEnd = 746.0;

struct SofteningShape {
  Shape shape = Shape::linear;
  double A = 0.5;       // integral of f from 0 to infinity
  double slope = 1.0;   // m = max |f'|
  double moment = 1.0;  // max xi |f'|
  double end = 1.0;     // f(xi >= end) = 0
  SofteningTable table;

  double factor(double xi) const {
    if (xi >= end) return 0.0;
    if (shape == Shape::exponential) return std::exp(-xi);
    if (shape == Shape::linear) return 1.0 - xi;
    int k = 1;
    while (xi >= table.x[k]) ++k;
    return table.f[k - 1] + (table.f[k] - table.f[k - 1]) * (xi - table.x[k - 1]) / (table.x[k] - table.x[k - 1]);
  }
};

}  // namespace quoin::shim
