#include "random/distribution.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "random/counter.h"

namespace quoin::random {
namespace {

constexpr int kDraws = 1000000;
constexpr double kNone = std::numeric_limits<double>::infinity();

struct Moments {
  double mean = 0.0, scatter = 0.0, least = kNone, most = -kNone;
};
Moments drawn(const Distribution& d) {
  Moments m;
  double squares = 0.0;
  const Sampler sampler(d);
  for (int i = 0; i < kDraws; ++i) {
    const double x = sampler.at_normal(normal({1, 2, 3}, static_cast<std::uint64_t>(i))) - d.mean;
    m.mean += x / kDraws;
    squares += x * x / kDraws;
    m.least = std::fmin(m.least, x + d.mean), m.most = std::fmax(m.most, x + d.mean);
  }
  m.scatter = std::sqrt(squares - m.mean * m.mean);
  m.mean += d.mean;
  return m;
}

// Compares with closed forms. Tolerances: 5 standard errors of 1e6 draws; that of the standard deviation s is
// s sqrt((kurtosis - 1)/(4 N)).
void expect_moments(const Distribution& d, double mean, double scatter, double kurtosis) {
  ASSERT_EQ(d.fault(), "");
  const Moments m = drawn(d);
  EXPECT_NEAR(m.mean, mean, 5.0 * scatter / std::sqrt(kDraws)) << shape_name(d.shape);
  EXPECT_NEAR(m.scatter, scatter, 5.0 * scatter * std::sqrt((kurtosis - 1.0) / (4.0 * kDraws))) << shape_name(d.shape);
}

TEST(Distribution, DrawsHaveTheirMeanAndScatter) {
  expect_moments({Shape::normal, 0.2e6, 0.05e6, -kNone, kNone}, 0.2e6, 0.05e6, 3.0);
  const double w = std::exp(std::log1p(0.4 * 0.4));  // kurtosis w^4 + 2 w^3 + 3 w^2 - 3
  expect_moments({Shape::lognormal, 0.2e6, 0.08e6, -kNone, kNone}, 0.2e6, 0.08e6,
                 w * w * w * w + 2 * w * w * w + 3 * w * w - 3);
  expect_moments({Shape::uniform, 0.0, 0.0, 2.0, 5.0}, 3.5, 3.0 / std::sqrt(12.0), 1.8);
  expect_moments({Shape::weibull, 3.0, 0.9, -kNone, kNone}, 3.0, 0.9, 3.0);
}

// Shape 2 is Rayleigh's distribution: standard deviation/mean = sqrt(4/pi - 1).
TEST(Distribution, WeibullFindsShapeAndScale) {
  const double mean = std::sqrt(M_PI) / 2;
  const Weibull w = weibull_of(mean, mean * std::sqrt(4 / M_PI - 1));
  EXPECT_NEAR(w.shape, 2.0, 1e-12);
  EXPECT_NEAR(w.scale, 1.0, 1e-12);
  const Weibull exponential = weibull_of(3.0, 3.0);
  EXPECT_NEAR(exponential.shape, 1.0, 1e-12);
  EXPECT_NEAR(exponential.scale, 3.0, 1e-11);
}

// Truncated normal distribution: mean + s (phi(a) - phi(b))/Z, variance s^2 (1 + (a phi(a) - b phi(b))/Z - (..)^2).
TEST(Distribution, TruncatedDrawsKeepTheirBoundsAndClosedForms) {
  const Distribution d{Shape::normal, 1.0, 0.5, 0.2, 1.8};
  const auto phi = [](double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI); };
  const double a = -1.6, b = 1.6, z = normal_probability(b) - normal_probability(a);
  const double scatter = 0.5 * std::sqrt(1 + (a * phi(a) - b * phi(b)) / z);
  expect_moments(d, 1.0, scatter, 3.0);
  const Moments m = drawn(d);
  EXPECT_GE(m.least, 0.2);
  EXPECT_LE(m.most, 1.8);
  const Distribution one_sided{Shape::normal, 1.0, 0.5, 0.2, kNone};
  const double expected = 1.0 + 0.5 * phi(a) / normal_probability(1.6);
  EXPECT_NEAR(Sampler(one_sided).mean(), expected, 1e-7);  // tolerance of the quadrature
}

TEST(Distribution, QuantilesAreThoseOfTheTables) {
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-14);
  EXPECT_NEAR(normal_quantile(1e-12), -7.034483825301132, 1e-12);
  const Distribution d{Shape::normal, 10.0, 2.0, -kNone, kNone};
  EXPECT_NEAR(Sampler(d).quantile(0.05), 10.0 - 2.0 * 1.6448536269514722, 1e-12);
}

// The conversion by the probability is exact also far in the tails.
TEST(Distribution, TailsOfWeibullAreExact) {
  const Distribution d{Shape::weibull, 3.0, 3.0, -kNone, kNone};  // exponential of mean 3
  EXPECT_NEAR(Sampler(d).at_normal(7.0), -3.0 * std::log(normal_probability(-7.0)), 1e-10);
  EXPECT_NEAR(Sampler(d).at_normal(-7.0) / (-3.0 * std::log1p(-normal_probability(-7.0))), 1.0, 1e-10);
}

// Extreme parameters are refused with a message, or have draws within the bounds and a mean.
TEST(Distribution, ExtremeNumbersAreRefusedOrDrawn) {
  int drawn = 0, refused = 0;
  const auto tried = [&](const Distribution& d) {
    const std::string what =
        fmt::format("{} {} {} from {} to {}", shape_name(d.shape), d.mean, d.scatter, d.lower, d.upper);
    if (!d.fault().empty()) return void(++refused);
    ++drawn;
    const auto is_within = [&](double x) { return std::isfinite(x) && x >= d.lower && x <= d.upper; };
    const Sampler sampler(d);
    EXPECT_PRED1(is_within, sampler.mean()) << what;
    for (const double z : {-8.3, -1.0, 0.0, 8.3}) EXPECT_PRED1(is_within, sampler.at_normal(z)) << what;
    for (const double p : {1e-17, 0.5, 1 - 1e-16}) EXPECT_PRED1(is_within, sampler.quantile(p)) << what;
  };
  for (const Shape shape : {Shape::normal, Shape::lognormal, Shape::weibull, Shape::uniform}) {
    for (const double mean : {-1e300, -3.0, 0.0, 5e-324, 1e-300, 0.2e6, 1e150, 1.7e308}) {
      for (const double scatter : {0.0, 5e-324, 1e-300, 1e-200, 1e-16, 1e-12, 1e-8, 0.3, 9.9, 1e3, 1e160, 1e300}) {
        for (const auto& [lower, upper] : {std::pair{-kNone, kNone},
                                           {0.0, kNone},
                                           {mean, kNone},
                                           {-kNone, 2 * mean},
                                           {0.999 * mean, 1.001 * mean},
                                           {-1.7e308, 1.7e308},
                                           {5e-324, 1e-323}}) {
          tried({shape, mean, scatter * std::abs(mean), lower, upper});
          tried({shape, mean, scatter, lower, upper});
        }
      }
    }
  }
  EXPECT_GT(drawn, 200);
  EXPECT_GT(refused, 1000);
}

// Draws are accurate far in the upper tail, where 1 minus a probability has no digits: z = 8.3 has 5e-17.
TEST(Distribution, DrawsOfTheUpperTailKeepTheirDigits) {
  const Distribution d{Shape::normal, 10.0, 1.0, 10.0, kNone};
  ASSERT_EQ(d.fault(), "");
  // Half of the draws remain, so that the probability above is half as large, and the mean is that of a folded normal.
  const double above = 0.5 * normal_probability(-8.3);
  EXPECT_NEAR(Sampler(d).at_normal(8.3), 10.0 - normal_quantile(above), 1e-9);
  EXPECT_NEAR(Sampler(d).mean(), 10.0 + std::sqrt(2 / std::acos(-1.0)), 1e-9);
}

TEST(Distribution, SaysWhatIsWrongWithIt) {
  EXPECT_THAT((Distribution{Shape::lognormal, -1.0, 0.1, -kNone, kNone}).fault(), testing::HasSubstr("more than 0"));
  EXPECT_THAT((Distribution{Shape::normal, 1.0, -0.1, -kNone, kNone}).fault(), testing::HasSubstr("scatter"));
  EXPECT_THAT((Distribution{Shape::uniform, 0.0, 0.0, 2.0, 1.0}).fault(), testing::HasSubstr("lower bound"));
  EXPECT_THAT((Distribution{Shape::uniform, 0.0, 0.0, 2.0, kNone}).fault(), testing::HasSubstr("lower and upper"));
  EXPECT_THAT((Distribution{Shape::normal, 0.0, 1.0, 20.0, 30.0}).fault(), testing::HasSubstr("millionth"));
  EXPECT_THAT((Distribution{Shape::weibull, 1.0, 0.001, -kNone, kNone}).fault(), testing::HasSubstr("weibull"));
}

}  // namespace
}  // namespace quoin::random
