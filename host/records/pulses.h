// Ground motion in closed form: pulses of the literature, for studies without records.
#pragma once

#include "base/time_series.h"

namespace quoin {

// amplitude: m/s2. duration: length of the pulse, s (period of the sine). step: between samples, s. At a jump of the
// closed form, two samples are closer. All begin and end at acceleration 0, except rectangle and cosine, which jump.
// Throws Error(bad_input) for values that are not finite, duration or step <= 0, or more than a million samples.

// Acceleration `amplitude` for `duration`. Rise and fall take a thousandth of it, with equal impulse.
TimeSeries rectangular_pulse(double amplitude, double duration);
// amplitude sin(2 pi t/T) over one period T: velocity amplitude T/pi at T/2 and 0 at the end (pulse of type A).
TimeSeries sine_pulse(double amplitude, double period, double step);
// amplitude cos(2 pi t/T) over one period: the displacement returns to 0 (pulse of type B).
TimeSeries cosine_pulse(double amplitude, double period, double step);
// Ricker's wavelet, (1 - 2 x^2) exp(-x^2) amplitude with x = pi (t - 1.5 T)/T, over 3 T; velocity and displacement end
// at 0.
TimeSeries ricker_pulse(double amplitude, double period, double step);
// Mavroeidis and Papageorgiou (2003): velocity (A/2)[1 + cos(w t'/gamma)] cos(w t' + phase), |t'| <= gamma/(2 f), w = 2
// pi f. A: m/s; f: Hz; gamma > 1: zero crossings; phase: rad. Returns its derivative, the acceleration.
TimeSeries mavroeidis_pulse(double velocity, double frequency, double gamma, double phase, double step);

}  // namespace quoin
