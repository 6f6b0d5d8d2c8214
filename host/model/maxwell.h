// Damping that is flat over a frequency band: Maxwell elements in parallel with the spring of a joint.
#pragma once

#include <array>

namespace quoin {

inline constexpr int kMaxwellElements = 3;

// A spring and a dashpot in series. Its traction s follows s' = share k u' - rate s, with the current joint stiffness
// k.
struct MaxwellElement {
  double share = 0.0;  // share of the joint's stiffness
  double rate = 0.0;   // 1/s
};

// Elements that relax at the ends of the band and at its geometric mean. With
//   K'/k = 1 + sum share x^2/(1 + x^2), K''/k = sum share x/(1 + x^2), x = omega/rate,
// the damping ratio of a vibration is K''/(2 K'). Shares are a least-squares fit over the logarithm of frequency. The
// ratio is then flat within 5 % for bands of 10 to 100 times and ratios up to 5 %. Ratio 0: no elements.
std::array<MaxwellElement, kMaxwellElements> maxwell_elements(double damping_ratio, std::array<double, 2> band_Hz);

}  // namespace quoin
