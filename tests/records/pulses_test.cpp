// Pulses against the integrals of their closed forms. Chords over steps of 1/1000 of a period have an error of 1e-5.
#include "records/pulses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "records/record.h"

namespace quoin {
namespace {

using std::numbers::pi;

TEST(Pulses, RectangleKeepsItsImpulse) {
  const RecordMeasures m = measure_record(rectangular_pulse(2.0, 0.4));
  EXPECT_NEAR(m.end_velocity, 0.8, 1e-12);
  EXPECT_DOUBLE_EQ(m.pga, 2.0);
}

TEST(Pulses, CosineComesBackInDisplacement) {
  const RecordMeasures m = measure_record(cosine_pulse(2.0, 0.5, 0.0005));
  EXPECT_NEAR(m.end_velocity, 0.0, 1e-9);
  EXPECT_NEAR(m.end_displacement, 0.0, 1e-9);
  EXPECT_NEAR(m.pgv, 2.0 * 0.5 / (2.0 * pi), 1e-5);
}

// v = A (t - 1.5 T) exp(-x^2): extremes at x = 1/sqrt(2), A T/(pi sqrt(2)) exp(-1/2). exp(-(1.5 pi)^2) = 2e-10 is cut
// off.
TEST(Pulses, RickerEndsAtRest) {
  const TimeSeries pulse = ricker_pulse(3.0, 0.7, 0.0007);
  EXPECT_NEAR(pulse.time.back(), 3 * 0.7, 0.0007);
  const RecordMeasures m = measure_record(pulse);
  EXPECT_NEAR(m.end_velocity, 0.0, 1e-8);
  EXPECT_NEAR(m.end_displacement, 0.0, 1e-8);
  EXPECT_NEAR(m.pgv, 3.0 * 0.7 / (pi * std::sqrt(2.0)) * std::exp(-0.5), 1e-5);
}

TEST(Pulses, MavroeidisHasItsVelocity) {
  const double a = 0.8, f = 1.5, gamma = 2.3, phase = 0.7;
  const TimeSeries series = mavroeidis_pulse(a, f, gamma, phase, 0.0005);
  const MotionHistory motion = integrate_acceleration(series);
  for (std::size_t i = 0; i < series.time.size(); i += 50) {
    const double t = series.time[i] - gamma / (2.0 * f);
    const double v = 0.5 * a * (1.0 + std::cos(2 * pi * f * t / gamma)) * std::cos(2 * pi * f * t + phase);
    EXPECT_NEAR(motion.velocity[i], v, 1e-5);
  }
}

// The step is the longest one allowed; whole numbers of it fit. A jump takes a thousandth of the pulse.
TEST(Pulses, StepsAreEqualAndNoLongerThanGiven) {
  EXPECT_EQ(sine_pulse(1.0, 1.0, 0.3).time, (std::vector{0.0, 0.25, 0.5, 0.75, 1.0}));
  EXPECT_EQ(cosine_pulse(1.0, 0.7, 0.1).time.size(), 8u);
  EXPECT_EQ(rectangular_pulse(2.0, 0.5).time, (std::vector{0.0, 0.0005, 0.5, 0.5005}));
}

TEST(Pulses, RefuseWhatHasNoMeaning) {
  EXPECT_ANY_THROW(rectangular_pulse(1.0, 0.0));
  EXPECT_ANY_THROW(sine_pulse(1.0, 1.0, 0.0));
  EXPECT_ANY_THROW(sine_pulse(1.0, 1.0, 1e-9));
  EXPECT_ANY_THROW(mavroeidis_pulse(1.0, 1.0, 1.0, 0.0, 0.01));
}

}  // namespace
}  // namespace quoin
