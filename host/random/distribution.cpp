#include "random/distribution.h"

#include <fmt/format.h>

#include <boost/math/distributions/lognormal.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/weibull.hpp>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>

namespace quoin::random {

namespace bm = boost::math;

namespace {

constexpr double kLargest = 1e100, kSmallest = 1e-100;  // bounds of numbers: squares and products are finite
constexpr double kFinest = 1e-9;  // least scatter over mean: a smaller one is lost in the digits of a value
// Bounds of scatter over mean. For Weibull its shape is then 0.1 to 130. For lognormal the logarithm has a scatter of 3
// at most.
constexpr double kLeastVariation = 0.01, kMostVariation = 10.0, kMostOfLognormal = 100.0;

// Calls f with a distribution of these parameters.
template <class F>
double with(Shape shape, double a, double b, const F& f) {
  if (shape == Shape::lognormal) return f(bm::lognormal(a, b));
  if (shape == Shape::weibull) return f(bm::weibull(a, b));
  return f(bm::normal(a, b));
}

struct Parameters {
  double a, b;
};
Parameters parameters_of(const Distribution& d) {
  if (d.shape == Shape::lognormal) {
    const double v = d.scatter / d.mean, s2 = std::log1p(v * v);
    return {std::log(d.mean) - 0.5 * s2, std::sqrt(s2)};
  }
  if (d.shape == Shape::weibull) {
    const Weibull w = weibull_of(d.mean, d.scatter);
    return {w.shape, w.scale};
  }
  return {d.mean, d.scatter};
}

double probability_below(const Distribution& d, double a, double b, double x) {  // before truncation
  if (std::isinf(x)) return x > 0 ? 1.0 : 0.0;
  if (x <= 0.0 && d.shape != Shape::normal) return 0.0;
  return with(d.shape, a, b, [&](const auto& known) { return bm::cdf(known, x); });
}

// Fault in the size of a number other than 0; empty: none.
std::string fault_of_size(const char* what, double value) {
  const double size = std::abs(value);
  if (value == 0.0 || (size >= kSmallest && size <= kLargest)) return "";
  return fmt::format("a {} of 0, or of {:g} to {:g} in size", what, kSmallest, kLargest);
}

}  // namespace

const char* shape_name(Shape shape) {
  switch (shape) {
    case Shape::normal:
      return "normal";
    case Shape::lognormal:
      return "lognormal";
    case Shape::weibull:
      return "weibull";
    case Shape::uniform:
      return "uniform";
  }
  return "?";
}

double normal_probability(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }
double normal_quantile(double probability) { return -std::sqrt(2.0) * bm::erfc_inv(2.0 * probability); }

Weibull weibull_of(double mean, double scatter) {
  const double variation = scatter / mean;
  const auto excess = [&](double k) {
    return bm::lgamma(1 + 2 / k) - 2 * bm::lgamma(1 + 1 / k) - std::log1p(variation * variation);
  };
  std::uintmax_t steps = 200;
  const auto [low, high] = bm::tools::toms748_solve(excess, 0.05, 500.0, bm::tools::eps_tolerance<double>(50), steps);
  const double shape = 0.5 * (low + high);
  return {shape, mean / std::tgamma(1 + 1 / shape)};
}

bool Distribution::truncated() const {
  return shape != Shape::uniform && (std::isfinite(lower) || std::isfinite(upper));
}

std::string Distribution::fault() const {
  if (!(lower < upper)) return fmt::format("a lower bound of less than the upper one, {:g}", upper);
  for (const double bound : {lower, upper}) {
    if (const std::string wrong = fault_of_size("bound", bound); std::isfinite(bound) && !wrong.empty()) return wrong;
  }
  if (shape == Shape::uniform)
    return std::isfinite(lower) && std::isfinite(upper) ? "" : "lower and upper for a uniform distribution";
  if (const std::string wrong = fault_of_size("mean", mean); !wrong.empty()) return wrong;
  if (!(scatter >= 0.0)) return "a scatter of 0 or more";
  if (const std::string wrong = fault_of_size("scatter", scatter); !wrong.empty()) return wrong;
  if (scatter > 0.0 && scatter < kFinest * std::abs(mean))
    return fmt::format("a scatter of 0, or of at least {:g} times the mean", kFinest);
  if (shape != Shape::normal && !(mean > 0.0)) return fmt::format("a mean of more than 0 for {}", shape_name(shape));
  if (shape == Shape::weibull && scatter > 0.0 &&
      !(scatter >= kLeastVariation * mean && scatter <= kMostVariation * mean))
    return fmt::format("a scatter of {:g} to {:g} times the mean for weibull", kLeastVariation, kMostVariation);
  if (shape == Shape::lognormal && scatter > kMostOfLognormal * mean)
    return fmt::format("a scatter of at most {:g} times the mean for lognormal", kMostOfLognormal);
  if (scatter == 0.0 && !(mean >= lower && mean <= upper)) return "a mean between the bounds where nothing scatters";
  if (scatter > 0.0 && truncated()) {
    const auto [a, b] = parameters_of(*this);
    if (!(probability_below(*this, a, b, upper) - probability_below(*this, a, b, lower) > 1e-6))
      return "bounds between which more than a millionth of the draws lies";
  }
  return "";
}

Sampler::Sampler(const Distribution& distribution) : distribution_(distribution) {
  if (distribution.shape == Shape::uniform || distribution.scatter == 0.0) return;
  const auto [a, b] = parameters_of(distribution);
  a_ = a, b_ = b;
  if (!distribution.truncated()) return;
  below_ = probability_below(distribution, a, b, distribution.lower);
  above_ = probability_below(distribution, a, b, distribution.upper);
}

double Sampler::at_normal(double z) const {
  // Directly, without the probability, where the shape permits.
  const Shape shape = distribution_.shape;
  if (!distribution_.truncated() && distribution_.scatter > 0.0) {
    if (shape == Shape::normal) return a_ + b_ * z;
    if (shape == Shape::lognormal) return std::exp(a_ + b_ * z);
  }
  return value_at(normal_probability(z), normal_probability(-z));
}

double Sampler::quantile(double probability) const { return value_at(probability, 1.0 - probability); }

double Sampler::value_at(double probability, double rest) const {
  const Distribution& d = distribution_;
  if (d.shape == Shape::uniform) return d.lower + probability * (d.upper - d.lower);
  if (d.scatter == 0.0) return d.mean;
  if (d.truncated()) {
    // Each from its own tail: the complement would be 0 in the far tail, which is no value of the distribution.
    probability = below_ + probability * (above_ - below_);
    rest = (1.0 - above_) + rest * (above_ - below_);
  }
  const double x = with(d.shape, a_, b_, [&](const auto& known) {
    return probability < 0.5 ? bm::quantile(known, probability) : bm::quantile(bm::complement(known, rest));
  });
  return std::fmin(std::fmax(x, d.lower), d.upper);
}

double Sampler::mean() const {
  const Distribution& d = distribution_;
  if (d.shape == Shape::uniform) return 0.5 * (d.lower + d.upper);
  if (!d.truncated()) return d.mean;
  bm::quadrature::tanh_sinh<double> rule;
  // to_end: distance to the nearer end, in full precision.
  const auto value = [&](double p, double to_end) {
    const double far = std::fmax(std::abs(to_end), std::numeric_limits<double>::min());
    return p < 0.5 ? value_at(far, 1.0 - far) : value_at(1.0 - far, far);
  };
  return std::fmin(std::fmax(rule.integrate(value, 0.0, 1.0, 1e-9), d.lower), d.upper);
}

}  // namespace quoin::random
