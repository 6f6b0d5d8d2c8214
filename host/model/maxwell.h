// Damping that is flat over a band of frequencies: Maxwell elements in parallel with the spring of a joint.
#pragma once

#include <array>

namespace quoin {

inline constexpr int kMaxwellElements = 3;

// A spring and a dashpot in a row. Its traction follows s' = share k u' - rate s, k the stiffness of the joint of now.
struct MaxwellElement {
  double share = 0.0;  // share of the joint's stiffness
  double rate = 0.0;   // 1/s
};

// Elements that relax at the ends of the band and at its geometric mean. With
//   K'/k = 1 + sum share x^2/(1 + x^2), K''/k = sum share x/(1 + x^2), x = omega/rate,
// the damping ratio of a vibration is K''/(2 K'). Shares by least squares over the logarithm of frequency; the ratio is
// then flat within 5 % for bands of 10 to 100 times and ratios up to 5 %. 0: none.
std::array<MaxwellElement, kMaxwellElements> maxwell_elements(double damping_ratio, std::array<double, 2> band_Hz);

}  // namespace quoin
