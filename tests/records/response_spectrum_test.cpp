// Response spectra against closed forms and against an independent integration of the equation of motion.
#include "records/response_spectrum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "records/pulses.h"

namespace quoin {
namespace {

using std::numbers::pi;

SpectralOrdinates ordinates(const TimeSeries& a, double damping, double period) {
  return response_spectrum(a, damping, std::array{period})[0];
}

// Undamped, under a constant acceleration: u = -(a/w^2)(1 - cos wt). Extremes are accurate to 0.05 %.
TEST(ResponseSpectrum, StepDoublesTheStaticResponse) {
  const TimeSeries step{{0.0, 10.0}, {1.5, 1.5}};
  for (const double period : {0.05, 0.4, 2.0}) {
    const SpectralOrdinates o = ordinates(step, 0.0, period);
    EXPECT_NEAR(o.pseudo_acceleration, 3.0, 3.0 * 5e-4) << period;
    EXPECT_NEAR(o.absolute_acceleration, 3.0, 3.0 * 5e-4) << period;
    EXPECT_NEAR(o.velocity, 1.5 * period / (2.0 * pi), 1e-3 * period) << period;
  }
}

// Undamped, under one full sine of period P: u = (A/w^2)/(1 - r^2) (sin Ot - r sin wt) until its end, r = O/w. Then the
// vibration is free.
TEST(ResponseSpectrum, SinePulseHasItsClosedForm) {
  const double a = 1.0, pulse = 0.5;
  const TimeSeries series = sine_pulse(a, pulse, pulse / 2000);
  for (const double period : {0.11, 0.3, 0.9, 2.7}) {
    const double w = 2.0 * pi / period, forcing = 2.0 * pi / pulse, r = forcing / w;
    const auto u = [&](double t) {
      return a / (w * w) / (1.0 - r * r) * (std::sin(forcing * t) - r * std::sin(w * t));
    };
    const auto v = [&](double t) {
      return a / (w * w) / (1.0 - r * r) * forcing * (std::cos(forcing * t) - std::cos(w * t));
    };
    double largest = std::hypot(u(pulse), v(pulse) / w);
    for (int i = 0; i <= 100000; ++i) largest = std::max(largest, std::abs(u(pulse * i / 100000.0)));
    EXPECT_NEAR(ordinates(series, 0.0, period).displacement, largest, 6e-4 * largest) << period;
  }
}

// Steady state under a long sine: sqrt((1 + (2 z r)^2)/((1 - r^2)^2 + (2 z r)^2)) of the base, after the transient has
// decayed. At r = 1 with 5 %: 10.0499 (absolute), 10 (relative).
TEST(ResponseSpectrum, ResonanceAmplifiesByOneOverTwiceTheDamping) {
  const double period = 0.5;
  TimeSeries series;
  for (int i = 0; i <= 20000; ++i) {
    series.time.push_back(0.0025 * i);
    series.value.push_back(std::sin(2.0 * pi * series.time.back() / period));
  }
  const SpectralOrdinates o = ordinates(series, 0.05, period);
  EXPECT_NEAR(o.pseudo_acceleration, 10.0, 10.0 * 1e-3);
  EXPECT_NEAR(o.absolute_acceleration, std::sqrt(1.0 + 100.0), 10.0 * 1e-3);
}

// Against the Runge-Kutta method with steps of 0.2 ms, a tenth of the shortest interval of the unequally spaced
// samples.
TEST(ResponseSpectrum, AgreesWithAnIndependentIntegration) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> step(0.002, 0.02);
  TimeSeries a{{0.0}, {0.0}};
  for (int i = 0; i < 400; ++i) a.time.push_back(a.time.back() + step(random)), a.value.push_back(normal(random));
  for (const double period : {0.08, 0.5, 3.0}) {
    for (const double zeta : {0.02, 0.3}) {
      const double w = 2.0 * pi / period, h = 2e-4;
      const auto rate = [&](double t, double u, double v) {
        return -(t <= a.time.back() ? a.at(t) : 0.0) - 2.0 * zeta * w * v - w * w * u;
      };
      double u = 0.0, v = 0.0, largest = 0.0;
      for (double t = 0.0; t < a.time.back() + period; t += h) {
        const double k1 = rate(t, u, v), k2 = rate(t + h / 2, u + h / 2 * v, v + h / 2 * k1);
        const double k3 = rate(t + h / 2, u + h / 2 * v + h * h / 4 * k1, v + h / 2 * k2);
        const double k4 = rate(t + h, u + h * v + h * h / 2 * k2, v + h * k3);
        u += h * v + h * h / 6 * (k1 + k2 + k3);
        v += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        largest = std::max(largest, std::abs(u));
      }
      EXPECT_NEAR(ordinates(a, zeta, period).displacement, largest, 1e-3 * largest) << period << " s, " << zeta;
    }
  }
}

// Peaks of velocities and accelerations lie between steps, near kinks of the record. In steps of a twentieth no peak is
// farther from a step than a fortieth, and the record is the same. Peaks were up to 1.5 % low.
TEST(ResponseSpectrum, PeaksBetweenStepsCount) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  TimeSeries coarse{{0.0}, {0.5}}, fine = coarse;
  for (int i = 1; i <= 300; ++i) {
    const double from = coarse.value.back(), to = normal(random);
    for (int k = 1; k <= 20; ++k)
      fine.time.push_back(0.01 * (i - 1 + k / 20.0)), fine.value.push_back(from + (to - from) * k / 20.0);
    coarse.time.push_back(0.01 * i), coarse.value.push_back(to);
  }
  const double peak = std::abs(*std::max_element(coarse.value.begin(), coarse.value.end(),
                                                 [](double a, double b) { return std::abs(a) < std::abs(b); }));
  for (const double period : {0.01, 0.03, 0.1, 0.3, 1.0, 5.0}) {
    for (const double zeta : {0.0, 0.05, 0.3, 0.7}) {
      const SpectralOrdinates o = ordinates(coarse, zeta, period), known = ordinates(fine, zeta, period);
      const auto expect = [&](double found, double largest, double times = 1.0) {
        EXPECT_NEAR(found, largest, 5e-4 * times * largest) << period << " s, " << zeta;
      };
      expect(o.displacement, known.displacement, 1.0 + peak / known.pseudo_acceleration);
      expect(o.velocity, known.velocity);
      expect(o.absolute_acceleration, known.absolute_acceleration);
    }
  }
}

// Oscillators of short period move with the ground, those of long period are at rest in space.
TEST(ResponseSpectrum, LimitsArePeakAccelerationAndPeakDisplacement) {
  const TimeSeries pulse = ricker_pulse(2.0, 0.6, 0.001);
  EXPECT_NEAR(ordinates(pulse, 0.05, 0.005).pseudo_acceleration, 2.0, 2e-3);
  // u, the double integral of the Ricker acceleration: A T^2/(2 pi^2) exp(-x^2).
  EXPECT_NEAR(ordinates(pulse, 0.0, 200.0).displacement, 2.0 * 0.36 / (2.0 * pi * pi), 2e-4);
}

// The displacement is multiplied by w and by w^2. Default periods: 0.02 to 5 s, in equal ratios.
TEST(ResponseSpectrum, PseudoOrdinatesAndDefaultPeriods) {
  const SpectralOrdinates o = ordinates(ricker_pulse(2.0, 0.6, 0.001), 0.05, 0.4);
  const double w = 2.0 * pi / 0.4;
  EXPECT_NEAR(o.pseudo_velocity, w * o.displacement, 1e-12);
  EXPECT_NEAR(o.pseudo_acceleration, w * w * o.displacement, 1e-12);
  const std::vector<double> periods = default_periods(3);
  EXPECT_NEAR(periods[0], 0.02, 1e-12);
  EXPECT_NEAR(periods[1], std::sqrt(0.02 * 5.0), 1e-12);
  EXPECT_NEAR(periods[2], 5.0, 1e-12);
}

TEST(ResponseSpectrum, RefusesWhatHasNoMeaning) {
  const TimeSeries a{{0.0, 1.0}, {1.0, 1.0}};
  EXPECT_ANY_THROW(ordinates(a, 1.0, 1.0));
  EXPECT_ANY_THROW(ordinates(a, -0.1, 1.0));
  EXPECT_ANY_THROW(ordinates(a, 0.05, 0.0));
  EXPECT_ANY_THROW(ordinates({{0.0}, {1.0}}, 0.05, 1.0));
}

}  // namespace
}  // namespace quoin
