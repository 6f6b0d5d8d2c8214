// Statistics of samples. NaN counts as a limit not reached.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace quoin::ensemble {

struct Interval {
  double low, high;
};

// Moments of independent samples. Intervals hold with 95 %: of the mean by Student's t, of the scatter by chi squared
// (for a normal distribution), of quantiles by order statistics.
struct Moments {
  std::size_t count = 0;
  double mean = 0.0, scatter = 0.0;
  Interval of_mean{}, of_scatter{};
};
Moments moments_of(const std::vector<double>& values);  // of finite values; with fewer than 2, intervals are NaN

// Quantile by linear interpolation between order statistics (Hazen).
double quantile_of(std::vector<double> values, double probability);
Interval quantile_interval(std::vector<double> values, double probability);

// Dependence of an output on an input.
struct Dependence {
  double pearson, spearman;  // correlations of the values, and of their ranks
  // Share of the output's variance explained by the input alone: Sobol's first-order index if inputs are independent.
  // It is computed by strata of equal count, and corrected for the bias of their number.
  double correlation_ratio;
};
std::optional<Dependence> dependence_of(const std::vector<double>& input, const std::vector<double>& output);

// Sobol's indices: shares of the variance of an output due to one input alone (first) and with its interactions
// (total). Inputs are independent. Intervals hold with 95 %, by resampling of rows.
struct SobolIndex {
  std::size_t rows = 0;  // number of rows in use
  double first = 0.0, total = 0.0;
  Interval of_first{}, of_total{};
};
// Index of an input by rows: outputs of two independent draws a and b of all inputs, and of a with this input from b.
// The first index is the estimate of Saltelli et al. (2010), total that of Jansen (1999). Rows with a missing output
// are left out. Nothing if fewer than 8 rows are left, or if the output does not vary.
std::optional<SobolIndex> sobol_index_of(const std::vector<double>& a, const std::vector<double>& b,
                                         const std::vector<double>& mixed);

// Fragility: P(limit reached at x) = Phi(ln(x/median)/spread).
struct Fragility {
  std::size_t samples = 0, reached = 0;
  double median = 0.0, spread = 0.0;
  Interval of_median{};  // 95 %; NaN where some samples have not reached the limit
  std::string fit;       // moments; order statistics, where some have not reached the limit; none
};
Fragility fragility_of(const std::vector<double>& values);

// Bounds, from one run or several, of the intensity at which a wall reaches a limit: above low, at most high. A low of
// 0 is no bound. A high of infinity: the limit was not reached at low.
struct Capacity {
  double low, high;
  std::size_t record;  // record of the run; runs of one record depend on each other
};
// Lognormal distribution of maximum likelihood. Intervals of 95 % by bootstrap of records; NaN with fewer than 3
// records.
class FittedFragility {
 public:
  // Nothing if the limit was reached always, or never, or no less often at lower intensities. seed: of the resampling.
  static std::optional<FittedFragility> of(const std::vector<Capacity>& capacities, std::uint64_t seed);
  double median = 0.0, spread = 0.0;
  bool spread_is_bound = false;  // whether every smaller spread is as likely
  Interval of_median{}, of_spread{};
  double probability(double intensity) const;
  Interval probability_interval(double intensity) const;

 private:
  std::vector<std::array<double, 2>> drawn_;  // median, spread
};

// A curve as force over a common displacement.
struct Curve {
  std::vector<double> displacement, force;  // m, growing; N
};
// Force at the first point with this displacement; NaN beyond the end of the curve.
double force_at(const Curve& curve, double displacement);

}  // namespace quoin::ensemble
