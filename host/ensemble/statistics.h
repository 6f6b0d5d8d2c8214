// What samples add up to. Values that are not a number count as not reached.
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

// Of independent samples. Intervals hold with 95 %: of the mean by Student's t, of the scatter by chi squared (for a
// normal distribution), of quantiles by order statistics.
struct Moments {
  std::size_t count = 0;
  double mean = 0.0, scatter = 0.0;
  Interval of_mean{}, of_scatter{};
};
Moments moments_of(const std::vector<double>& values);  // finite ones; at least 2, else intervals are not a number

// By linear interpolation between order statistics (Hazen).
double quantile_of(std::vector<double> values, double probability);
Interval quantile_interval(std::vector<double> values, double probability);

// How an output follows an input.
struct Dependence {
  double pearson, spearman;  // correlations of the values, and of their ranks
  // Share of the variance of the output that the input explains by itself: its first-order index of Sobol where inputs
  // are independent. By strata of equal count, with the bias of their number taken out.
  double correlation_ratio;
};
std::optional<Dependence> dependence_of(const std::vector<double>& input, const std::vector<double>& output);

// Shares of the variance of an output by one input alone (first) and with its interactions (total): Sobol's indices, of
// independent inputs. Intervals hold with 95 %, by drawing the rows again.
struct SobolIndex {
  std::size_t rows = 0;  // that were used
  double first = 0.0, total = 0.0;
  Interval of_first{}, of_total{};
};
// Rows by rows: the output of independent draws a and b of all inputs, and of a with this input taken from b. The first
// index is as Saltelli et al. (2010) estimate it, total as Jansen (1999). Rows in which one of the three is missing are
// left out; nothing where fewer than 8 are left, or where the output does not vary.
std::optional<SobolIndex> sobol_index_of(const std::vector<double>& a, const std::vector<double>& b,
                                         const std::vector<double>& mixed);

// P(reached at x) = Phi(ln(x/median)/spread).
struct Fragility {
  std::size_t samples = 0, reached = 0;
  double median = 0.0, spread = 0.0;
  Interval of_median{};  // 95 %; not a number where some have not reached it
  std::string fit;       // moments; order statistics, where some have not reached it; none
};
Fragility fragility_of(const std::vector<double>& values);

// Bounds from one run, or several, of the intensity at which a wall reaches a limit. It lies above low, and not above
// high. low 0: it may be anything up to high; high infinite: it was not reached at low.
struct Capacity {
  double low, high;
  std::size_t record;  // record of the run; runs of one record depend on each other
};
// The lognormal distribution of greatest likelihood. Intervals of 95 % by drawing records again (bootstrap); not a
// number with fewer than 3 records.
class FittedFragility {
 public:
  // Nothing where no limit was reached, or where none was not. seed: of the draws.
  static std::optional<FittedFragility> of(const std::vector<Capacity>& capacities, std::uint64_t seed);
  double median = 0.0, spread = 0.0;
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
// Force where the displacement is first reached; not a number beyond the end.
double force_at(const Curve& curve, double displacement);

}  // namespace quoin::ensemble
