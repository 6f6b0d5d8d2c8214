// Distributions of one number. Quantiles by Boost.Math.
#pragma once

#include <limits>
#include <string>

namespace quoin::random {

enum class Shape { normal, lognormal, weibull, uniform };

// mean and scatter (standard deviation) are those before truncation to [lower, upper]; a uniform distribution lies
// between them, and has neither.
struct Distribution {
  Shape shape = Shape::normal;
  double mean = 0.0, scatter = 0.0;
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();

  bool truncated() const;
  // What is wrong with it, as "a mean of more than 0 for lognormal"; empty: nothing.
  std::string fault() const;
};

// Draws from one, with what takes a while done once.
class Sampler {
 public:
  explicit Sampler(const Distribution& distribution);  // one without a fault
  // The value that a standard normal variable of this value stands for: they have the same probability.
  double at_normal(double z) const;
  double quantile(double probability) const;  // in (0, 1)
  double mean() const;                        // mean of all draws, by quadrature where truncated

 private:
  double value_at(double probability, double rest) const;  // rest: 1 - probability, without loss
  Distribution distribution_;
  double a_ = 0.0, b_ = 1.0;          // mean and scatter; of the logarithm; shape and scale of Weibull
  double below_ = 0.0, above_ = 1.0;  // probabilities of the bounds, before truncation
};

const char* shape_name(Shape shape);

// The normal distribution of mean 0 and scatter 1.
double normal_probability(double z);         // that a draw is below z
double normal_quantile(double probability);  // in (0, 1)

// Shape and scale of a Weibull distribution, P(X > x) = exp(-(x/scale)^shape).
struct Weibull {
  double shape, scale;
};
Weibull weibull_of(double mean, double scatter);  // both more than 0, scatter/mean 0.01 to 10

}  // namespace quoin::random
