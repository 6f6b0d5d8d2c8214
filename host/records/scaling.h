// Scale of a record to a given intensity.
#pragma once

#include "base/time_series.h"

namespace quoin {

struct IntensityTarget {
  enum class Measure { pga, pgv, spectral_acceleration } measure = Measure::pga;
  double value = 0.0;     // m/s2, or m/s for pgv; > 0
  double period = 0.0;    // period of the spectral (pseudo-) acceleration, s
  double damping = 0.05;  // damping of the spectrum, share of critical
};

// Factor on the acceleration for this intensity; all three measures are proportional to it. Throws Error(bad_input) for
// values out of range, and for a record that is 0 throughout.
double scale_to(const TimeSeries& acceleration, const IntensityTarget& target);

}  // namespace quoin
