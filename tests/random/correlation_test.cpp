#include "random/correlation.h"

#include <gmock/gmock.h>

#include <cmath>

#include "random/counter.h"

namespace quoin::random {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

TEST(Correlation, MixedVariablesHaveTheCorrelationsGiven) {
  const std::vector<double> wanted{1, 0.8, -0.3, 0.8, 1, 0.1, -0.3, 0.1, 1};
  const std::vector<double> mix = mix_of(wanted, 3);
  ASSERT_EQ(mix.size(), 9u);
  constexpr int kDraws = 300000;  // draws of three numbers
  std::vector<double> found(9, 0.0);
  for (int i = 0; i < kDraws; ++i) {
    double z[3] = {}, fresh[3];
    for (std::uint64_t k = 0; k < 3; ++k) fresh[k] = normal({1, 1, k}, static_cast<std::uint64_t>(i));
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t m = 0; m <= k; ++m) z[k] += mix[3 * k + m] * fresh[m];
    for (std::size_t k = 0; k < 9; ++k) found[k] += z[k / 3] * z[k % 3] / kDraws;
  }
  // Tolerance of 5 standard errors; that of the mean of a product is sqrt((1 + r^2)/N).
  for (std::size_t k = 0; k < 9; ++k)
    EXPECT_NEAR(found[k], wanted[k], 5.0 * std::sqrt((1 + wanted[k] * wanted[k]) / kDraws)) << k;
  EXPECT_TRUE(mix_of({1, 0.9, -0.9, 0.9, 1, 0.9, -0.9, 0.9, 1}, 3).empty());
}

// Correlation of lognormal values: (exp(r s1 s2) - 1)/sqrt((exp(s1^2) - 1)(exp(s2^2) - 1)), r: that of the normal
// values.
TEST(Correlation, LognormalValuesAreCorrelatedAsInClosedForm) {
  const Sampler d({Shape::lognormal, 2.0, 1.0, -kNone, kNone});
  const double s2 = std::log1p(0.25), r = 0.7;
  constexpr int kDraws = 500000;
  const Follow mix{r, std::sqrt(1 - r * r)};
  double product = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const auto element = static_cast<std::uint64_t>(i);
    const double a = normal({1, 1, 1}, element), b = mix.share * a + mix.fresh * normal({1, 1, 2}, element);
    product += (d.at_normal(a) - 2.0) * (d.at_normal(b) - 2.0) / kDraws;
  }
  // Tolerance of 5 standard errors; measured over seeds 1 to 20 that is 0.004.
  EXPECT_NEAR(product, (std::exp(r * s2) - 1) / (std::exp(s2) - 1), 0.02);
}

// 1e6 numbers along lines of 20 unequally spaced positions.
TEST(Correlation, AFieldHasItsCorrelationLengthAndItsMeansTheVarianceFunction) {
  constexpr int kLines = 50000;
  constexpr std::size_t kPlaces = 20;
  constexpr double kLength = 0.3, kStep = 0.05;
  double pair[kPlaces] = {}, square_of_mean = 0.0, mean_of_mean = 0.0;
  for (int line = 0; line < kLines; ++line) {
    double z = 0.0, first = 0.0, sum = 0.0;
    for (std::size_t k = 0; k < kPlaces; ++k) {
      const Follow f = k == 0 ? Follow{0.0, 1.0} : follow(kStep, kLength);
      z = f.share * z + f.fresh * normal({1, static_cast<std::uint64_t>(line), 5}, k);
      if (k == 0) first = z;
      pair[k] += first * z / kLines;
      sum += z / kPlaces;
    }
    mean_of_mean += sum / kLines;
    square_of_mean += sum * sum / kLines;
  }
  for (std::size_t k = 0; k < kPlaces; ++k) {
    const double r = std::exp(-kStep * static_cast<double>(k) / kLength);
    EXPECT_NEAR(pair[k], r, 5.0 * std::sqrt((1 + r * r) / kLines)) << k;
  }
  // The mean over 20 positions with 0.05 m each is that over 1 m, up to the variance within 0.05 m: 5.4 %, by
  // variance_of_mean(0.05, 0.3) = 0.946.
  const double of_line = variance_of_mean(kStep * kPlaces, kLength);
  EXPECT_NEAR(of_line, 2 * 0.09 * (1 / 0.3 - 1 + std::exp(-1 / 0.3)), 1e-12);
  EXPECT_NEAR(mean_of_mean, 0.0, 5.0 * std::sqrt(of_line / kLines));
  EXPECT_NEAR(square_of_mean, of_line, of_line * (5.0 * std::sqrt(2.0 / kLines) + 0.01));
}

TEST(Correlation, VarianceOfAMeanOfAShortIntervalIsThatOfAPoint) {
  EXPECT_DOUBLE_EQ(variance_of_mean(0.0, 1.0), 1.0);
  EXPECT_NEAR(variance_of_mean(0.99e-3, 1.0), variance_of_mean(1.01e-3, 1.0), 1e-5);  // at the limit of both formulas
  EXPECT_NEAR(variance_of_mean(1e4, 1.0), 2e-4, 1e-7);                                // scale of fluctuation over T
}

// Without a length points are independent, also those of one x: the variance of a mean of n is 1/n. They counted as
// equal, and means scattered by a third to three quarters of what was asked.
TEST(Correlation, PointsWithoutALengthAreIndependent) {
  const std::vector<double> x(16, 0.3), weight(16, 1.0 / 16.0);
  for (const Shape shape : {Shape::normal, Shape::lognormal}) {
    const Distribution of_mean{shape, 2e9, 0.2e9, -kNone, kNone};
    EXPECT_NEAR(of_points(of_mean, 0.0, x, weight).scatter, 4.0 * 0.2e9, 1e-6 * 0.2e9) << shape_name(shape);
    EXPECT_NEAR(of_points(of_mean, 0.1, x, weight).scatter, 0.2e9, 1e-6 * 0.2e9) << "one place of a field";
  }
}

// Mean and standard deviation of the average over a joint are those requested.
TEST(Correlation, PointsScatterMoreSoThatTheirMeanScattersAsGiven) {
  const std::vector<double> x{0.0, 0.0275, 0.055, 0.0825, 0.11}, weight{0.125, 0.25, 0.25, 0.25, 0.125};
  constexpr double kLength = 0.05;
  constexpr int kDraws = 200000;  // draws of five numbers
  for (const Shape shape : {Shape::normal, Shape::lognormal}) {
    const Distribution of_mean{shape, 0.2e6, 0.06e6, -kNone, kNone};
    const Distribution points = of_points(of_mean, kLength, x, weight);
    EXPECT_GT(points.scatter, 1.1 * of_mean.scatter);
    const Sampler sampler(points);
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < kDraws; ++i) {
      double z = 0.0, mean = 0.0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        const Follow f = k == 0 ? Follow{0.0, 1.0} : follow(x[k] - x[k - 1], kLength);
        z = f.share * z + f.fresh * normal({2, static_cast<std::uint64_t>(i), 5}, k);
        mean += weight[k] * sampler.at_normal(z);
      }
      sum += (mean - 0.2e6) / kDraws;
      squares += (mean - 0.2e6) * (mean - 0.2e6) / kDraws;
    }
    EXPECT_NEAR(sum, 0.0, 5.0 * 0.06e6 / std::sqrt(kDraws)) << shape_name(shape);
    // Tolerance of 5 standard errors of a standard deviation, for a kurtosis up to 5.
    EXPECT_NEAR(std::sqrt(squares), 0.06e6, 5.0 * 0.06e6 / std::sqrt(kDraws)) << shape_name(shape);
  }
}

}  // namespace
}  // namespace quoin::random
