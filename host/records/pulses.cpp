#include "records/pulses.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "base/error.h"

namespace quoin {
namespace {

constexpr double kMostSamples = 1e6;
constexpr double kRise = 1e-3;  // duration of a jump over that of the pulse

using std::numbers::pi;

void require(bool good, const char* what, double value, const char* allowed) {
  if (!good) throw Error(Exit::bad_input, fmt::format("{} {} of a pulse; allowed: {}", what, value, allowed));
}

void require_positive(const char* what, double value) {
  require(value > 0.0 && std::isfinite(value), what, value, "more than 0, finite");
}

// Samples f over [0, length] with equal steps.
template <class Function>
TimeSeries sampled(double length, double step, const Function& f) {
  require_positive("duration", length), require_positive("step", step);
  const double count = std::ceil(length / step * (1.0 - 1e-12));
  require(count <= kMostSamples, "number of samples", count, "up to 1e6; choose a longer step");
  TimeSeries series;
  for (double i = 0.0; i <= count; ++i) {
    series.time.push_back(i * length / count);
    series.value.push_back(f(series.time.back()));
  }
  return series;
}

}  // namespace

TimeSeries rectangular_pulse(double amplitude, double duration) {
  require(std::isfinite(amplitude), "amplitude", amplitude, "a finite number");
  require_positive("duration", duration);
  const double rise = kRise * duration;  // ramps centred at 0 and at the end, shifted so that time begins at 0
  return {{0.0, rise, duration, duration + rise}, {0.0, amplitude, amplitude, 0.0}};
}

TimeSeries sine_pulse(double amplitude, double period, double step) {
  return sampled(period, step, [&](double t) { return amplitude * std::sin(2.0 * pi * t / period); });
}

TimeSeries cosine_pulse(double amplitude, double period, double step) {
  return sampled(period, step, [&](double t) { return amplitude * std::cos(2.0 * pi * t / period); });
}

TimeSeries ricker_pulse(double amplitude, double period, double step) {
  return sampled(3.0 * period, step, [&](double t) {
    const double x = pi * (t - 1.5 * period) / period;
    return amplitude * (1.0 - 2.0 * x * x) * std::exp(-x * x);
  });
}

TimeSeries mavroeidis_pulse(double velocity, double frequency, double gamma, double phase, double step) {
  require_positive("frequency", frequency);
  require(gamma > 1.0 && std::isfinite(gamma), "gamma", gamma, "more than 1");
  const double w = 2.0 * pi * frequency, half = gamma / (2.0 * frequency);
  return sampled(2.0 * half, step, [&](double t) {
    const double x = w * (t - half);
    return -0.5 * velocity * w *
           (std::sin(x / gamma) / gamma * std::cos(x + phase) + (1.0 + std::cos(x / gamma)) * std::sin(x + phase));
  });
}

}  // namespace quoin
