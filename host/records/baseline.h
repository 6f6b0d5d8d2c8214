// Baseline correction: what instruments and processing leave at zero frequency.
#pragma once

#include "base/time_series.h"

namespace quoin {

struct BaselineCorrection {
  enum class Kind { none, polynomial, high_pass } kind = Kind::none;
  int order = 1;           // order of the polynomial, 0 to 10 (linear: 1), or of the Butterworth filter, 1 to 8
  double corner_Hz = 0.0;  // corner of the filter, above 0 and below a quarter of the sampling rate
};

// polynomial: less the polynomial of that order that fits the acceleration best (least squares).
// high_pass: Butterworth, forwards and backwards, so without shift of phase and with twice the order's decay (-6 dB at
// the corner). The record is extended by zeros for 1.5 * order / corner at both ends (Boore 2005). What lies before the
// first sample is cut again, so the velocity there is not exactly 0. Needs equal steps of time. Throws
// Error(bad_input).
TimeSeries correct_baseline(const TimeSeries& acceleration, const BaselineCorrection& correction);

}  // namespace quoin
