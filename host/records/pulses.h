// Ground motion in closed form: pulses of the literature, from which a study can begin without a record.
#pragma once

#include "base/time_series.h"

namespace quoin {

// amplitude: m/s2. duration: length of the pulse, s (period of the sine). step: between samples, s. Where the closed
// form jumps, two samples stand closer. All begin and end at acceleration 0 but the jumps of rectangle and cosine.
// Throws Error(bad_input): values that are not finite, duration or step <= 0, more than a million samples.

// Acceleration `amplitude` for `duration`; rise and fall within a thousandth of it, which keeps the impulse.
TimeSeries rectangular_pulse(double amplitude, double duration);
// amplitude sin(2 pi t/T) over one period T: velocity amplitude T/pi at T/2 and 0 at the end (pulse of type A).
TimeSeries sine_pulse(double amplitude, double period, double step);
// amplitude cos(2 pi t/T) over one period: displacement comes back to 0 (pulse of type B).
TimeSeries cosine_pulse(double amplitude, double period, double step);
// Ricker's wavelet, (1 - 2 x^2) exp(-x^2) amplitude with x = pi (t - 1.5 T)/T, over 3 T; velocity and displacement end
// at 0.
TimeSeries ricker_pulse(double amplitude, double period, double step);
// Mavroeidis and Papageorgiou (2003): velocity (A/2)[1 + cos(w t'/gamma)] cos(w t' + phase), |t'| <= gamma/(2 f), w = 2
// pi f. A: m/s; f: Hz; gamma > 1: zero crossings; phase: rad. Returns the acceleration, its derivative.
TimeSeries mavroeidis_pulse(double velocity, double frequency, double gamma, double phase, double step);

}  // namespace quoin
