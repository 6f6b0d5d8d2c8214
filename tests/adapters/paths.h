// Paths for the comparison of every adapter with the law called directly. Growing cycles of opening, of sliding under
// pressure and of compression far exceed the strengths of tests/mortar.h.
#pragma once

#include <array>
#include <cmath>
#include <utility>

namespace quoin::tests {

enum class Leg { tension, shear, compression };
inline constexpr std::array legs = {std::pair{Leg::tension, "tension"}, std::pair{Leg::shear, "shear"},
                                    std::pair{Leg::compression, "compression"}};
inline constexpr int leg_steps = 2000;

// Returns the total (d_n, d_s, d_t) at the end of a step, m.
inline std::array<double, 3> displacement(Leg leg, int step) {
  const double t = static_cast<double>(step) / leg_steps;
  const double cycle = t * (1.0 + 0.6 * std::sin(40.0 * t));
  switch (leg) {
    case Leg::tension:
      return {2e-4 * cycle, 1e-6 * t, -2e-6 * cycle};
    case Leg::shear:
      return {-2e-6, 2e-3 * cycle, 5e-4 * t * std::sin(25.0 * t)};
    default:
      return {-4e-4 * cycle, 1e-7 * cycle, 0.0};
  }
}

}  // namespace quoin::tests
