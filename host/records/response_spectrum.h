// Elastic response spectra of ground and floor motions.
#pragma once

#include <span>
#include <vector>

#include "base/time_series.h"

namespace quoin {

// Largest responses of u'' + 2 zeta w u' + w^2 u = -a(t), at rest at the first sample, for one period T = 2 pi/w.
struct SpectralOrdinates {
  double period = 0.0;                 // s
  double displacement = 0.0;           // Sd, relative to the ground, m
  double velocity = 0.0;               // relative to the ground, m/s
  double pseudo_velocity = 0.0;        // w Sd, m/s
  double pseudo_acceleration = 0.0;    // w^2 Sd, m/s2: Sa of codes
  double absolute_acceleration = 0.0;  // m/s2
};

// Exact for an acceleration (m/s2) that is linear between samples (Nigam and Jennings 1969), during the record and one
// period after it. In steps, 100 or more a period; extremes of velocity and acceleration between these by cubics:
// within 0.05 %, and of displacement at most 0.05 % (1 + PGA/Sa) low. damping: share of critical, [0, 1); periods: s, >
// 0. Throws Error(bad_input).
std::vector<SpectralOrdinates> response_spectrum(const TimeSeries& acceleration, double damping,
                                                 std::span<const double> periods);

// Periods from 0.02 to 5 s, in equal steps of the logarithm.
std::vector<double> default_periods(std::size_t count = 200);

}  // namespace quoin
