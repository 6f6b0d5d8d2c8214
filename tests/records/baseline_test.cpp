#include "records/baseline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "records/record.h"

namespace quoin {
namespace {

using std::numbers::pi;

// The least-squares correction removes an added polynomial, to rounding.
TEST(Baseline, PolynomialThatWasAddedIsRemoved) {
  TimeSeries drift;
  for (int i = 0; i <= 4000; ++i) {
    const double t = 0.01 * i;
    drift.time.push_back(t);
    drift.value.push_back(0.3 - 0.02 * t + 0.001 * t * t - 2e-5 * t * t * t);
  }
  const TimeSeries left = correct_baseline(drift, {BaselineCorrection::Kind::polynomial, 3, 0.0});
  for (const double value : left.value) EXPECT_NEAR(value, 0.0, 1e-12);
}

// Order 0 takes the mean away. As many coefficients as samples leave nothing.
TEST(Baseline, LowestAndHighestOrder) {
  using Kind = BaselineCorrection::Kind;
  TimeSeries two{{0.0, 1.0}, {1.0, 4.0}};
  const TimeSeries level = correct_baseline(two, {Kind::polynomial, 0, 0.0});
  EXPECT_NEAR(level.value[0], -1.5, 1e-12);
  EXPECT_NEAR(level.value[1], 1.5, 1e-12);
  for (const double left : correct_baseline(two, {Kind::polynomial, 1, 0.0}).value) EXPECT_NEAR(left, 0.0, 1e-12);
  EXPECT_ANY_THROW(correct_baseline(two, {Kind::polynomial, -1, 0.0}));
  for (int i = 2; i <= 10; ++i) two.time.push_back(i), two.value.push_back(i % 3);
  for (const double left : correct_baseline(two, {Kind::polynomial, 10, 0.0}).value) EXPECT_NEAR(left, 0.0, 1e-9);
  EXPECT_EQ(correct_baseline(two, {Kind::high_pass, 8, 0.2}).value.size(), two.value.size());
  EXPECT_ANY_THROW(correct_baseline(two, {Kind::high_pass, 9, 0.2}));
}

// Two passes of a Butterworth filter of order n: gain 1/(1 + (fc/f)^(2n)), no phase shift. In the middle of a long
// sine.
TEST(Baseline, HighPassHasItsGainAndNoShiftOfPhase) {
  const double corner = 0.5, step = 0.005;
  for (const int order : {1, 2, 3, 4}) {
    for (const double f : {0.25, 0.5, 1.0, 5.0}) {
      TimeSeries sine;
      for (int i = 0; i <= 16000; ++i)
        sine.time.push_back(step * i), sine.value.push_back(std::sin(2 * pi * f * step * i));
      const TimeSeries out = correct_baseline(sine, {BaselineCorrection::Kind::high_pass, order, corner});
      // The bilinear transform distorts frequencies: tan(pi f h) replaces f.
      const double ratio = std::tan(pi * corner * step) / std::tan(pi * f * step);
      const double gain = 1.0 / (1.0 + std::pow(ratio, 2 * order));
      double in_phase = 0.0, out_of_phase = 0.0;
      for (int i = 6000; i < 10000; ++i) {  // 20 s: whole periods of each
        in_phase += out.value[static_cast<std::size_t>(i)] * std::sin(2 * pi * f * step * i) / 2000.0;
        out_of_phase += out.value[static_cast<std::size_t>(i)] * std::cos(2 * pi * f * step * i) / 2000.0;
      }
      EXPECT_NEAR(in_phase, gain, 1e-6) << order << ", " << f << " Hz";
      EXPECT_NEAR(out_of_phase, 0.0, 1e-6) << order << ", " << f << " Hz";
    }
  }
}

// The zeros that the filter adds are enough. A pulse at the end of a record is filtered as it is, and with many more
// zeros before and behind it. The values differ by less than 1e-3 of the pulse. If the zeros were too short, the
// backward pass would begin within the response, and the difference would be of the order of the pulse.
TEST(Baseline, HighPassHasRoomForItsResponse) {
  const double step = 0.01;
  TimeSeries record, longer;
  constexpr int kMore = 4000;
  for (int i = 0; i <= 400; ++i) record.time.push_back(step * i), record.value.push_back(i > 300 ? 1.0 : 0.0);
  for (int i = -kMore; i <= 400 + kMore; ++i)
    longer.time.push_back(step * (i + kMore)), longer.value.push_back(i > 300 && i <= 400 ? 1.0 : 0.0);
  const BaselineCorrection filter{BaselineCorrection::Kind::high_pass, 2, 0.1};
  const TimeSeries here = correct_baseline(record, filter), there = correct_baseline(longer, filter);
  for (std::size_t i = 0; i < here.value.size(); ++i)
    ASSERT_NEAR(here.value[i], there.value[i + kMore], 1e-3) << record.time[i];
}

TEST(Baseline, RefusesOrdersCornersAndUnequalSteps) {
  const TimeSeries even{{0.0, 0.1, 0.2}, {0.0, 1.0, 0.0}}, uneven{{0.0, 0.1, 0.3}, {0.0, 1.0, 0.0}};
  using Kind = BaselineCorrection::Kind;
  EXPECT_ANY_THROW(correct_baseline(even, {Kind::polynomial, 11, 0.0}));
  EXPECT_ANY_THROW(correct_baseline(even, {Kind::polynomial, 3, 0.0}));  // three samples
  EXPECT_ANY_THROW(correct_baseline(even, {Kind::high_pass, 2, 0.0}));
  EXPECT_ANY_THROW(correct_baseline(even, {Kind::high_pass, 2, 2.6}));
  EXPECT_ANY_THROW(correct_baseline(uneven, {Kind::high_pass, 2, 0.1}));
  // One sample was read beyond its end. A corner of 1e-12 Hz ended in "out of memory", one of 1e-300 in a cast that is
  // not defined.
  EXPECT_ANY_THROW(correct_baseline({{0.0}, {1.0}}, {Kind::high_pass, 2, 0.1}));
  for (const double corner : {1e-12, 1e-300, 2.9e-6}) {
    try {
      correct_baseline(even, {Kind::high_pass, 2, corner});
      ADD_FAILURE() << corner;
    } catch (const Error& error) {  // 1.5 * 2 periods of 1/corner in 1e7 steps of 0.1 s
      EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("baseline_corner"), testing::HasSubstr("3e-06 Hz")));
    }
  }
  EXPECT_EQ(correct_baseline(uneven, {}).value, uneven.value);
}

}  // namespace
}  // namespace quoin
