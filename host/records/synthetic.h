// Artificial records that match the response spectrum of a code, from a seed.
#pragma once

#include <cstdint>

#include "records/record.h"

namespace quoin {

// Horizontal elastic response spectrum of EN 1998-1:2004, 3.2.2.2.
struct DesignSpectrum {
  double ground_acceleration = 1.0;  // a_g on ground type A, m/s2, > 0
  char ground_type = 'A';            // A to E, tables 3.2 and 3.3
  int type = 1;                      // 1: magnitudes above 5.5; 2: up to 5.5
  double damping = 0.05;             // share of critical; eta = sqrt(10/(5 + 100 damping)) >= 0.55
  // S_e(T), m/s2. period: s, >= 0. Throws Error(bad_input) for values outside of these ranges.
  double acceleration(double period) const;
  bool operator==(const DesignSpectrum&) const = default;
};

struct SyntheticSettings {
  double duration = 20.0;   // s: 10 % rising, 50 % strong, 40 % falling
  double time_step = 0.01;  // s
  std::uint64_t seed = 1;
  std::uint64_t number = 0;  // number of the record in its suite
  bool operator==(const SyntheticSettings&) const = default;
};

// Random phases under an envelope, with amplitudes corrected until the spectrum fits between 0.05 and 4 s. It is at
// rest at both ends (velocity and displacement 0 to rounding). Bitwise identical for equal seed and number.
struct SyntheticRecord {
  GroundRecord record;       // one component
  double mean_ratio = 0.0;   // pseudo-acceleration over target, mean over 60 periods from 0.05 to 4 s
  double worst_ratio = 0.0;  // least of these ratios
};
// Throws Error(bad_input) for a duration below 5 s, a time step of 0 or above 0.02 s, or more than a million samples.
SyntheticRecord synthetic_record(const DesignSpectrum& target, const SyntheticSettings& settings);

}  // namespace quoin
