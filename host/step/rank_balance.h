// Load balancing: when a repartition of blocks is worth its cost, by the measured work of the ranks.
//
// Uneven work costs what the slowest rank takes beyond the mean, for all wait for it. A repartition costs what the last
// one took. It is due when the accumulated loss has reached that cost. So no more time goes into repartitions than is
// lost without them, however costs drift. A repartition that leaves the ranks uneven doubles the loss that the next one
// needs.
#pragma once

#include <span>
#include <vector>

namespace quoin {

double most_over_mean(std::span<const double> values);  // 1: all are equal

class RankBalance {
 public:
  static constexpr long kWindow = 256;      // steps of a window of measurement
  static constexpr double kUneven = 1.15;   // largest / mean work above which a window is uneven; noise is below it
  static constexpr int kWindowsInARow = 2;  // uneven windows in a row before a repartition: a single one is chance

  // Adds a window and returns whether a repartition is worth its cost. By rank: measured work, s; estimated work, any
  // unit. Both are equal on all ranks, and so is the result.
  bool is_worth_dividing(std::span<const double> seconds, std::span<const double> estimated);
  // Measured over estimated work by rank in the current uneven windows, relative to that of all ranks together.
  std::vector<double> measured_over_estimated() const;
  void divided(double seconds);                    // a repartition has taken this time, s
  void costs(double seconds) { cost_ = seconds; }  // estimated cost of the first repartition, s

 private:
  void reset();

  std::vector<double> spent_, estimated_;  // by rank, over the current uneven windows
  int in_a_row_ = 0;
  double lost_ = 0.0, cost_ = 0.0;  // lost in these windows; cost of a repartition, s
  double patience_ = 1.0;           // loss that is needed, over cost_
};

}  // namespace quoin
