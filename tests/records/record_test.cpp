// Integrals and measures of records against closed forms.
#include "records/record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "records/pulses.h"
#include "records/scaling.h"

namespace quoin {
namespace {

using std::numbers::pi;

// A sine pulse: v(T/2) = A T/pi, v(T) = 0, u(T) = A T^2/(2 pi). Chords of a sine have an error of (pi h/T)^2/3 = 3e-6
// at T/h = 1000.
TEST(Record, SinePulseHasItsClosedFormMeasures) {
  const double a = 3.0, period = 0.8;
  const RecordMeasures m = measure_record(sine_pulse(a, period, period / 1000));
  EXPECT_NEAR(m.pga, a, 1e-5 * a);
  EXPECT_NEAR(m.pgv, a * period / pi, 1e-5 * a);
  EXPECT_NEAR(m.end_velocity, 0.0, 1e-12);
  EXPECT_NEAR(m.end_displacement, a * period * period / (2.0 * pi), 1e-5 * a);
  EXPECT_NEAR(m.pgd, m.end_displacement, 1e-12);
  EXPECT_NEAR(m.arias, pi / (2.0 * kStandardGravity) * a * a * period / 2.0, 1e-4);
}

// a = 1 - t over [0, 2], two samples: v is largest at t = 1, between them: 1/2. u(2) = 2 - 8/6 = 2/3.
TEST(Record, VelocityTurnsBetweenSamples) {
  const RecordMeasures m = measure_record({{0.0, 2.0}, {1.0, -1.0}});
  EXPECT_DOUBLE_EQ(m.pgv, 0.5);
  EXPECT_DOUBLE_EQ(m.end_velocity, 0.0);
  EXPECT_DOUBLE_EQ(m.end_displacement, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(m.arias, pi / (2.0 * kStandardGravity) * 2.0 / 3.0);  // of (1 - t)^2
}

// Constant acceleration: the intensity grows linearly, so 90 % of it takes 90 % of the time.
TEST(Record, SignificantDurationOfConstantAcceleration) {
  TimeSeries a;
  for (int i = 0; i <= 100; ++i) a.time.push_back(0.1 * i), a.value.push_back(-2.0);
  EXPECT_NEAR(measure_record(a).significant_duration, 9.0, 1e-9);
  EXPECT_NEAR(measure_record({{0.0, 10.0}, {-2.0, -2.0}}).significant_duration, 9.0, 1e-12);  // within a step
}

// Parabolas of the velocity, and a cubic of the displacement that is at rest at both ends, are exact at unequal steps.
TEST(Record, UnequalStepsAreExactForPolynomials) {
  GroundRecord velocity{"", MotionKind::velocity, {0.0, 0.1, 0.4, 0.5, 1.0}, {{"v", {}}}, {}}, displacement = velocity;
  displacement.kind = MotionKind::displacement;
  for (const double t : velocity.time) {
    velocity.components[0].value.push_back(1.0 + 2.0 * t - 3.0 * t * t);
    displacement.components[0].value.push_back(t * t * (3.0 - 2.0 * t));
  }
  const TimeSeries from_v = acceleration_of(velocity, 0), from_u = acceleration_of(displacement, 0);
  for (std::size_t i = 0; i < velocity.time.size(); ++i) {
    EXPECT_NEAR(from_v.value[i], 2.0 - 6.0 * velocity.time[i], 1e-12) << i;
    EXPECT_NEAR(from_u.value[i], 6.0 - 12.0 * velocity.time[i], 1e-12) << i;
  }
  const GroundRecord two{"", MotionKind::velocity, {0.0, 0.5}, {{"v", {1.0, 3.0}}}, {}};
  EXPECT_EQ(acceleration_of(two, 0).value, (std::vector{4.0, 4.0}));
}

// v = w cos(w t), a = -w^2 sin(w t): differences have errors of (w h)^2/6. u = 1 - cos(w t), at rest at both ends:
// those of a cubic spline are (w h)^2/12, of a = w^2 cos(w t).
TEST(Record, VelocitiesAndDisplacementsBecomeAccelerations) {
  const double w = 2.0 * pi, h = 0.002;
  GroundRecord velocity{"", MotionKind::velocity, {}, {{"v", {}}}, {}};
  GroundRecord displacement{"", MotionKind::displacement, {}, {{"u", {}}}, {}};
  for (int i = 0; i <= 1000; ++i) {
    const double t = h * i;
    velocity.time.push_back(t), displacement.time.push_back(t);
    velocity.components[0].value.push_back(w * std::cos(w * t));
    displacement.components[0].value.push_back(1.0 - std::cos(w * t));
  }
  const TimeSeries from_v = acceleration_of(velocity, 0), from_u = acceleration_of(displacement, 0);
  for (std::size_t i = 1; i < 1000; ++i) {
    const double exact = -w * w * std::sin(w * velocity.time[i]);
    EXPECT_NEAR(from_v.value[i], exact, w * w * w * w * h * h / 6.0 * 1.01);
  }
  for (std::size_t i = 0; i <= 1000; ++i)  // ends too, where second differences have errors of (w h)^2/2
    EXPECT_NEAR(from_u.value[i], w * w * std::cos(w * velocity.time[i]), w * w * w * w * h * h / 12.0 * 1.01);
}

TEST(Record, ScalesToEachIntensity) {
  const TimeSeries a = sine_pulse(2.0, 0.5, 0.001);
  EXPECT_NEAR(scale_to(a, {IntensityTarget::Measure::pga, 5.0}), 2.5, 1e-4);
  EXPECT_NEAR(scale_to(a, {IntensityTarget::Measure::pgv, 2.0 * 0.5 / pi * 3.0}), 3.0, 1e-4);
  const IntensityTarget sa{IntensityTarget::Measure::spectral_acceleration, 4.0, 0.3, 0.05};
  TimeSeries scaled = a;
  for (double& value : scaled.value) value *= scale_to(a, sa);
  EXPECT_NEAR(scale_to(scaled, sa), 1.0, 1e-12);
  EXPECT_ANY_THROW(scale_to({{0.0, 1.0}, {0.0, 0.0}}, sa));
  EXPECT_ANY_THROW(scale_to(a, {IntensityTarget::Measure::pga, -1.0}));
}

}  // namespace
}  // namespace quoin
