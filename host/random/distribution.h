// Distributions of one random number. Quantiles are those of Boost.Math.
#pragma once

#include <limits>
#include <string>

namespace quoin::random {

enum class Shape { normal, lognormal, weibull, uniform };

// mean and scatter (standard deviation) are before truncation to [lower, upper]. A uniform distribution has the bounds
// alone.
struct Distribution {
  Shape shape = Shape::normal;
  double mean = 0.0, scatter = 0.0;
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();

  bool truncated() const;
  // Fault of the distribution, as "a mean of more than 0 for lognormal"; empty: none.
  std::string fault() const;
};

// Computes values of a distribution. Its parameters are computed once.
class Sampler {
 public:
  explicit Sampler(const Distribution& distribution);  // without a fault
  // Value with the probability of z in a standard normal distribution.
  double at_normal(double z) const;
  double quantile(double probability) const;  // probability in (0, 1)
  double mean() const;                        // mean of all values, by quadrature if truncated

 private:
  double value_at(double probability, double rest) const;  // rest: 1 - probability, in full precision
  Distribution distribution_;
  double a_ = 0.0, b_ = 1.0;          // mean and scatter; those of the logarithm; or shape and scale of Weibull
  double below_ = 0.0, above_ = 1.0;  // probabilities of the bounds, before truncation
};

const char* shape_name(Shape shape);

// Standard normal distribution.
double normal_probability(double z);         // probability of a value below z
double normal_quantile(double probability);  // probability in (0, 1)

// Shape and scale of a Weibull distribution, P(X > x) = exp(-(x/scale)^shape).
struct Weibull {
  double shape, scale;
};
Weibull weibull_of(double mean, double scatter);  // both more than 0, scatter/mean 0.01 to 10

}  // namespace quoin::random
