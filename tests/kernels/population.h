// Materials and random points for comparison of kernels. Bitwise identical on every machine: only integers and exact
// operations, without distributions of the standard library.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "plugin.h"
#include "tests/mortar.h"

namespace quoin::test {

inline constexpr const char* laws[] = {"elastic", "coulomb_slip", "fracture_energy", "cyclic_joint", "bond_slip"};

// Returns materials for every branch of the law: shape, coupling, and compression elastic, crushing, or crushing with
// residuals and dilation.
inline std::vector<Values> materials(const std::string& law) {
  const auto first = [](std::size_t n) {
    return Values{{mortar::properties.begin(), mortar::properties.begin() + n}, {}, {}};
  };
  if (law == "elastic") return {first(2)};
  if (law == "coulomb_slip") {
    Values residual = first(5);
    residual.numbers.insert(
        residual.numbers.end(),
        {{"tensile_strength_residual", 0.02e6}, {"cohesion_residual", 0.05e6}, {"friction_angle_residual", 28.0}});
    return {first(5), residual};
  }
  if (law == "bond_slip") {
    Values bonded = first(2), peels = bonded;
    bonded.numbers.insert(bonded.numbers.end(), {{"bond_strength", 0.3e6}, {"fracture_energy", 15.0}});
    peels.numbers.insert(peels.numbers.end(),
                         {{"bond_strength", 0.3e6}, {"peel_strength", 0.2e6}, {"fracture_energy", 5.0}});
    return {first(2), bonded, peels};
  }
  std::vector<Values> all;
  if (law == "cyclic_joint") {
    // Neutral values without crushing, neutral values with crushing, and all features together.
    for (const char* shape : {"linear", "exponential", "table"}) {
      for (int variant = 0; variant < 3; ++variant) {
        Values v = first(mortar::properties.size());
        v.words = {{"softening", shape}};
        if (std::strcmp(shape, "table") == 0) v.table = {0.0, 1.0, 0.3, 0.5, 1.0, 0.0};
        if (variant == 0) v.numbers[5].second = HUGE_VAL;
        if (variant == 2) {
          v.numbers.insert(v.numbers.end(), {{"dilation_angle", 12.0},
                                             {"friction_angle_residual", 28.0},
                                             {"cohesion_residual", 0.05e6},
                                             {"compressive_strength_residual", 0.5e6},
                                             {"residual_opening", 0.3},
                                             {"dilation_length", 1e-4},
                                             {"dilation_pressure", 1.5e6},
                                             {"compressive_yield", 2e6},
                                             {"compressive_peak_closure", 2e-5},
                                             {"crushing_recovery", 0.5},
                                             {"cap_shear", 4.0}});
        }
        all.push_back(v);
      }
    }
    return all;
  }
  for (const char* shape : {"linear", "exponential", "table"}) {
    for (const char* coupling : {"shared", "none"}) {
      for (int variant = 0; variant < 3; ++variant) {
        Values v = first(mortar::properties.size());
        v.words = {{"softening", shape}, {"coupling", coupling}};
        if (std::strcmp(shape, "table") == 0) v.table = {0.0, 1.0, 0.3, 0.5, 1.0, 0.0};
        if (variant == 0) v.numbers[5].second = HUGE_VAL;
        if (variant == 2) {
          v.numbers.insert(v.numbers.end(), {{"dilation_angle", 12.0},
                                             {"friction_angle_residual", 28.0},
                                             {"cohesion_residual", 0.05e6},
                                             {"compressive_strength_residual", 0.5e6}});
        }
        all.push_back(v);
      }
    }
  }
  return all;
}

// Returns a uniform random number in [-1, 1).
inline double unit(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; }

// Sets new jumps and slips of all points. One random number in each expression, since the order of operands is
// unspecified.
inline void randomise(Batch& b, std::mt19937_64& random) {
  for (std::size_t i = 0; i < b.count; ++i) {
    const double reach = unit(random) > 0.0 ? 1e-4 : 8e-5;
    b.in[0][i] = reach * unit(random);
    b.in[1][i] = 1e-5 * unit(random);
    b.in[2][i] = 1e-5 * unit(random);
  }
}

// Sets some jumps to +0 or -0, some to sizes from 1e-15 to 1 m, and a few to NaN or infinity; a few old values, too.
inline void make_some_extreme(Batch& b, std::mt19937_64& random) {
  const double not_finite[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < b.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto choice = random() % 256;
      const double any = unit(random);
      const int halvings = static_cast<int>(random() % 50);
      if (choice < 24) b.in[k][i] = std::copysign(0.0, any);
      if (choice >= 24 && choice < 40) b.in[k][i] = std::ldexp(any, -halvings);
      if (choice >= 40 && choice < 43) b.in[k][i] = not_finite[choice - 40];
    }
    if (random() % 512 == 0) {
      const std::size_t column = 3 + random() % (b.in.size() - 3);
      b.in[column][i] = not_finite[random() % 3];
    }
  }
}

}  // namespace quoin::test
