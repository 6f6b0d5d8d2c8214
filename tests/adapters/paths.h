// The paths on which every adapter is compared with the law called directly: growing cycles of opening, of sliding
// under pressure and of compression, far beyond the strengths of `mortar`.
#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace quoin::tests {

enum class Leg { tension, shear, compression };
inline constexpr std::array legs = {std::pair{Leg::tension, "tension"}, std::pair{Leg::shear, "shear"},
                                    std::pair{Leg::compression, "compression"}};
inline constexpr int leg_steps = 2000;

// Total (d_n, d_s, d_t) at the end of a step, m.
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

// Table 1 of the paper, mortar joint; each law takes those that it knows.
inline const std::vector<std::pair<const char*, double>> mortar = {{"normal_stiffness", 82e9},
                                                                   {"shear_stiffness", 36e9},
                                                                   {"tensile_strength", 0.2e6},
                                                                   {"cohesion", 0.3e6},
                                                                   {"friction_angle", 35.0},
                                                                   {"compressive_strength", 5e6},
                                                                   {"fracture_energy_tension", 15.0},
                                                                   {"fracture_energy_shear", 125.0},
                                                                   {"fracture_energy_compression", 8000.0}};

}  // namespace quoin::tests
