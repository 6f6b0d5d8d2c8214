// Baseline correction: removes errors of instruments and processing at low frequency.
#pragma once

#include "base/time_series.h"

namespace quoin {

struct BaselineCorrection {
  enum class Kind { none, polynomial, high_pass } kind = Kind::none;
  int order = 1;           // order of the polynomial, 0 to 10 (linear: 1), or of the Butterworth filter, 1 to 8
  double corner_Hz = 0.0;  // corner of the filter, above 0 and below a quarter of the sampling rate
};

// polynomial: subtracts the polynomial that fits the acceleration best (least squares).
// high_pass: Butterworth, forwards and backwards: no phase shift, twice the order's decay, -6 dB at the corner. The
// record is extended by zeros for 1.5 * order / corner at both ends (Boore 2005). The part before the first sample is
// then removed, so that the velocity there is not exactly 0. Requires equal time steps. Throws Error(bad_input).
TimeSeries correct_baseline(const TimeSeries& acceleration, const BaselineCorrection& correction);

}  // namespace quoin
