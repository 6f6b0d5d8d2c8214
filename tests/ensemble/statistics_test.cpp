#include "ensemble/statistics.h"

#include <gmock/gmock.h>

#include <cmath>

#include "random/counter.h"

namespace quoin::ensemble {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double normal(std::uint64_t of, std::size_t i) { return random::normal({1, 1, of}, i); }

// By hand: mean 3, variance 2.5; t(4) at 97.5 % is 2.776445, chi squared(4) 0.484419 and 11.14329 (tables).
TEST(Statistics, MomentsAndTheirIntervals) {
  const Moments m = moments_of({1, 2, kNone, 3, 4, 5});
  EXPECT_EQ(m.count, 5u);
  EXPECT_DOUBLE_EQ(m.mean, 3.0);
  EXPECT_DOUBLE_EQ(m.scatter, std::sqrt(2.5));
  EXPECT_NEAR(m.of_mean.high - 3.0, 2.776445 * std::sqrt(2.5 / 5), 1e-5);
  EXPECT_NEAR(m.of_scatter.low, std::sqrt(10.0 / 11.14329), 1e-5);
  EXPECT_NEAR(m.of_scatter.high, std::sqrt(10.0 / 0.484419), 1e-4);
}

// 95 of 100 intervals hold the truth, up to the scatter of a binomial: 5 sqrt(0.05 0.95/1000).
TEST(Statistics, IntervalsHoldTheTruthAsOftenAsTheySay) {
  int mean = 0, scatter = 0, median = 0;
  constexpr int kTrials = 1000;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    std::vector<double> v;
    for (std::size_t i = 0; i < 30; ++i) v.push_back(normal(trial, i));
    const Moments m = moments_of(v);
    mean += m.of_mean.low < 0 && m.of_mean.high > 0;
    scatter += m.of_scatter.low < 1 && m.of_scatter.high > 1;
    const Interval i = quantile_interval(v, 0.5);
    median += i.low < 0 && i.high > 0;
  }
  const double allowed = 5 * std::sqrt(0.05 * 0.95 / kTrials);
  EXPECT_NEAR(mean / double(kTrials), 0.95, allowed);
  EXPECT_NEAR(scatter / double(kTrials), 0.95, allowed);
  // Order statistics are steps: at least 95 %, here 95.7 % or 97.7 %.
  EXPECT_GT(median / double(kTrials), 0.95 - allowed);
}

TEST(Statistics, QuantilesAreHazens) {
  EXPECT_DOUBLE_EQ(quantile_of({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(quantile_of({4, 1, 3, 2}, 0.125), 1.0);
  EXPECT_DOUBLE_EQ(quantile_of({4, 1, 3, 2}, 0.999), 4.0);
  EXPECT_TRUE(std::isnan(quantile_interval({1, 2, 3}, 0.05).low));  // too few to say
}

// y = 2 a + b: a explains 4/5 of the variance, b 1/5, c none.
TEST(Statistics, CorrelationRatiosAreTheFirstIndices) {
  std::vector<double> a, b, c, y;
  for (std::size_t i = 0; i < 4000; ++i) {
    a.push_back(normal(1, i)), b.push_back(normal(2, i)), c.push_back(normal(3, i));
    y.push_back(2 * a[i] + b[i]);
  }
  // 20 strata of a normal variable lose 2 % of it; 5 standard errors of 4000 samples are 0.05.
  EXPECT_NEAR(dependence_of(a, y)->correlation_ratio, 0.8, 0.06);
  EXPECT_NEAR(dependence_of(b, y)->correlation_ratio, 0.2, 0.06);
  EXPECT_NEAR(dependence_of(c, y)->correlation_ratio, 0.0, 0.02);
  EXPECT_NEAR(dependence_of(a, y)->pearson, std::sqrt(0.8), 0.02);
  // Of a monotonic function the ranks are the same.
  std::vector<double> bent;
  for (const double v : a) bent.push_back(std::exp(3 * v));
  EXPECT_DOUBLE_EQ(dependence_of(a, bent)->spearman, 1.0);
  EXPECT_FALSE(dependence_of(a, std::vector<double>(a.size(), 1.0)));
}

TEST(Statistics, FragilitiesFindTheirLognormalDistribution) {
  std::vector<double> drift;
  for (std::size_t i = 0; i < 2000; ++i) drift.push_back(0.004 * std::exp(0.5 * normal(4, i)));
  const Fragility all = fragility_of(drift);
  EXPECT_EQ(all.fit, "moments");
  EXPECT_NEAR(all.median, 0.004, 0.004 * 5 * 0.5 / std::sqrt(2000));
  EXPECT_NEAR(all.spread, 0.5, 5 * 0.5 / std::sqrt(4000));
  EXPECT_LT(all.of_median.low, all.median);
  // Tests that end at a drift of 4.5 mm: what comes later is not seen, and is not taken for never.
  for (double& v : drift) v = v > 0.0045 ? kNone : v;
  const Fragility some = fragility_of(drift);
  EXPECT_EQ(some.fit, "order statistics");
  EXPECT_LT(some.reached, some.samples);
  EXPECT_NEAR(some.median, 0.004, 0.0003);
  EXPECT_NEAR(some.spread, 0.5, 0.06);
  EXPECT_EQ(fragility_of({1, kNone, 2}).fit, "none");
}

TEST(Statistics, ForcesComeFromTheCurve) {
  const Curve c{{0, 1, 2}, {0, 10, 5}};
  EXPECT_DOUBLE_EQ(force_at(c, 0.5), 5.0);
  EXPECT_DOUBLE_EQ(force_at(c, 1.5), 7.5);
  EXPECT_DOUBLE_EQ(force_at(c, 0.0), 0.0);
  EXPECT_TRUE(std::isnan(force_at(c, 2.1)));
}

}  // namespace
}  // namespace quoin::ensemble
