#include "ensemble/statistics.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "ensemble/study.h"
#include "random/counter.h"
#include "random/design.h"

namespace quoin::ensemble {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double normal(std::uint64_t of, std::size_t i) { return random::normal({1, 1, of}, i); }

// Computed by hand: mean 3, variance 2.5; t(4) at 97.5 % is 2.776445, chi squared(4) 0.484419 and 11.14329 (tables).
TEST(Statistics, MomentsAndTheirIntervals) {
  const Moments m = moments_of({1, 2, kNone, 3, 4, 5});
  EXPECT_EQ(m.count, 5u);
  EXPECT_DOUBLE_EQ(m.mean, 3.0);
  EXPECT_DOUBLE_EQ(m.scatter, std::sqrt(2.5));
  EXPECT_NEAR(m.of_mean.high - 3.0, 2.776445 * std::sqrt(2.5 / 5), 1e-5);
  EXPECT_NEAR(m.of_scatter.low, std::sqrt(10.0 / 11.14329), 1e-5);
  EXPECT_NEAR(m.of_scatter.high, std::sqrt(10.0 / 0.484419), 1e-4);
}

// 95 of 100 intervals contain the true value, with a tolerance of 5 standard deviations, 5 sqrt(0.05 0.95/1000).
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
  EXPECT_TRUE(std::isnan(quantile_interval({1, 2, 3}, 0.05).low));  // too few values
}

// Tables of confidence intervals of a median at 95 %: samples 1 and 6 of 6, 2 and 9 of 10, 40 and 61 of 100. Quantiles
// p and 1 - p have mirrored bounds. The lower bounds were one sample too low.
TEST(Statistics, BoundsOfQuantilesAreTheNarrowestThatHold) {
  const auto ranks = [](std::size_t count, double probability) {
    std::vector<double> v;
    for (std::size_t i = 1; i <= count; ++i) v.push_back(double(i));
    const Interval i = quantile_interval(v, probability);
    return std::pair(i.low, i.high);
  };
  EXPECT_EQ(ranks(6, 0.5), std::pair(1.0, 6.0));
  EXPECT_EQ(ranks(10, 0.5), std::pair(2.0, 9.0));
  EXPECT_EQ(ranks(100, 0.5), std::pair(40.0, 61.0));
  EXPECT_EQ(ranks(100, 0.05).first, 1.0);
  EXPECT_EQ(ranks(100, 0.95).second, 100.0);
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
  // A monotonic function does not change the ranks.
  std::vector<double> bent;
  for (const double v : a) bent.push_back(std::exp(3 * v));
  EXPECT_DOUBLE_EQ(dependence_of(a, bent)->spearman, 1.0);
  EXPECT_FALSE(dependence_of(a, std::vector<double>(a.size(), 1.0)));
}

// Returns values of a function of n independent inputs, uniform in (0, 1). The inputs are a, b, and a with one input of
// b at a time.
template <class Function>
std::vector<std::vector<double>> exchanged(std::size_t rows, std::size_t n, const Function& function) {
  const random::Design design{random::Method::sobol, 1, 0, 2 * n};
  std::vector<std::vector<double>> outputs(n + 2);
  for (std::size_t row = 1; row <= rows; ++row) {
    for (std::size_t place = 0; place < n + 2; ++place) {
      std::vector<double> x;
      for (std::size_t k = 0; k < n; ++k) x.push_back(design.at(row, place == 1 || place == k + 2 ? n + k : k));
      outputs[place].push_back(function(x));
    }
  }
  return outputs;
}

// Ishigami and Homma (1990): sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, x in (-pi, pi), with indices in closed form.
// Tolerance of three half widths of the intervals for 2048 rows, which are 0.02 to 0.13 wide.
TEST(Statistics, SobolIndicesOfIshigamisFunction) {
  constexpr double a = 7.0, b = 0.1, pi = M_PI;
  const double alone1 = 0.5 * std::pow(1 + b * std::pow(pi, 4) / 5, 2), alone2 = a * a / 8;
  const double together13 = b * b * std::pow(pi, 8) * 8 / 225, all = alone1 + alone2 + together13;
  const std::array first{alone1 / all, alone2 / all, 0.0};
  const std::array total{(alone1 + together13) / all, alone2 / all, together13 / all};
  EXPECT_NEAR(first[0], 0.3139, 1e-4);  // as printed by Saltelli et al. (2008)
  const auto y = exchanged(2048, 3, [&](const std::vector<double>& u) {
    const double x1 = pi * (2 * u[0] - 1), x2 = pi * (2 * u[1] - 1), x3 = pi * (2 * u[2] - 1);
    return std::sin(x1) + a * std::sin(x2) * std::sin(x2) + b * std::pow(x3, 4) * std::sin(x1);
  });
  for (std::size_t k = 0; k < 3; ++k) {
    const auto s = sobol_index_of(y[0], y[1], y[k + 2]);
    ASSERT_TRUE(s);
    EXPECT_NEAR(s->first, first[k], 1.5 * (s->of_first.high - s->of_first.low)) << k;
    EXPECT_NEAR(s->total, total[k], 1.5 * (s->of_total.high - s->of_total.low)) << k;
    EXPECT_LT(s->of_first.high - s->of_first.low, 0.15) << k;
    EXPECT_LT(s->of_total.high - s->of_total.low, 0.15) << k;
  }
}

// y = 2 x1 + x2 + 0 x3: first and total indices are 4/5, 1/5 and 0. Failed rows are excluded.
TEST(Statistics, SobolIndicesOfASum) {
  auto y = exchanged(512, 3, [](const std::vector<double>& x) { return 1000 + 2 * x[0] + x[1]; });
  y[0][3] = y[2][7] = y[3][9] = kNone;
  const std::array share{0.8, 0.2, 0.0};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto s = sobol_index_of(y[0], y[1], y[k + 2]);
    ASSERT_TRUE(s);
    EXPECT_EQ(s->rows, k == 2 ? 511u : 510u);
    EXPECT_NEAR(s->first, share[k], 0.02);
    EXPECT_NEAR(s->total, share[k], 0.02);
  }
  EXPECT_FALSE(sobol_index_of(std::vector(20, 1.0), std::vector(20, 1.0), std::vector(20, 1.0)));
  EXPECT_FALSE(sobol_index_of({1, 2, 3}, {2, 3, 1}, {1, 1, 2}));
}

// 95 of 100 intervals contain the true value, for random rows. Tolerance of 5 standard deviations, and 0.05 for
// intervals of 100 rows.
TEST(Statistics, IntervalsOfSobolIndicesHoldTheTruth) {
  constexpr int kTrials = 100, kRows = 100;
  int first = 0, total = 0;
  for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
    std::vector<double> a, b, mixed;
    for (std::size_t i = 0; i < kRows; ++i) {
      const double x = normal(5 * trial + 10, i), other_x = normal(5 * trial + 11, i);
      const double y = normal(5 * trial + 12, i), other_y = normal(5 * trial + 13, i);
      a.push_back(x + y), b.push_back(other_x + other_y), mixed.push_back(other_x + y);
    }
    const auto s = sobol_index_of(a, b, mixed);
    ASSERT_TRUE(s);
    first += s->of_first.low < 0.5 && s->of_first.high > 0.5;
    total += s->of_total.low < 0.5 && s->of_total.high > 0.5;
  }
  const double allowed = 0.05 + 5 * std::sqrt(0.05 * 0.95 / kTrials);
  EXPECT_NEAR(first / double(kTrials), 0.95, allowed);
  EXPECT_NEAR(total / double(kTrials), 0.95, allowed);
}

TEST(Statistics, FragilitiesFindTheirLognormalDistribution) {
  std::vector<double> drift;
  for (std::size_t i = 0; i < 2000; ++i) drift.push_back(0.004 * std::exp(0.5 * normal(4, i)));
  const Fragility all = fragility_of(drift);
  EXPECT_EQ(all.fit, "moments");
  EXPECT_NEAR(all.median, 0.004, 0.004 * 5 * 0.5 / std::sqrt(2000));
  EXPECT_NEAR(all.spread, 0.5, 5 * 0.5 / std::sqrt(4000));
  EXPECT_LT(all.of_median.low, all.median);
  // Tests that end at a drift of 4.5 mm: later values are censored.
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

// Samples for Sobol's indices (Saltelli et al. 2010): a row has inputs a, inputs b, and a with one input of b at a
// time. One at a time, each input is a standard deviation below its mean, then above.
TEST(Statistics, TrialsChangeOneInputAtATime) {
  Study study;
  for (const double mean : {1.0, 10.0, 100.0})
    study.quantities.push_back({fmt::format("q{:g}", mean), "", {random::Shape::normal, mean, 0.1 * mean}});
  study.samples = 15;
  study.trials = Trials::exchanged;
  constexpr std::size_t n = 3;
  std::vector<double> before;
  for (std::uint64_t row = 0; row < 3; ++row) {
    const std::uint64_t first = 1 + row * (n + 2);
    const std::vector<double> a = study.values(first), b = study.values(first + 1);
    EXPECT_NE(a, before);
    before = a;
    for (std::size_t changed = 0; changed < n; ++changed) {
      const std::vector<double> mixed = study.values(first + 2 + changed);
      for (std::size_t k = 0; k < n; ++k) {
        EXPECT_NE(a[k], b[k]);
        EXPECT_EQ(mixed[k], k == changed ? b[k] : a[k]) << row << ", " << changed << ", " << k;
      }
    }
  }
  study.trials = Trials::one_at_a_time;
  const std::vector<double> means = study.values(0);
  for (std::uint64_t sample = 1; sample <= 2 * n; ++sample) {
    std::vector<double> expected = means;
    const std::size_t k = (sample - 1) / 2;
    expected[k] += sample % 2 == 1 ? -0.1 * means[k] : 0.1 * means[k];
    const std::vector<double> tried = study.values(sample);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(tried[i], expected[i], 1e-12 * means[i]) << sample << ", " << i;
  }
}

}  // namespace
}  // namespace quoin::ensemble
