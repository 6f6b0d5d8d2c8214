// When blocks are worth being divided among ranks again, by what their own work of steps has taken.
//
// Unevenness costs what the slowest rank takes beyond the mean, for all wait for it; dividing costs what it took last
// time. Blocks are divided once the first has reached the second. So no more is spent on dividing than was lost without
// it, however costs drift. A division that leaves the ranks uneven doubles the loss that the next one needs.
#pragma once

#include <span>
#include <vector>

namespace quoin {

double most_over_mean(std::span<const double> values);  // 1: all are equal

class RankBalance {
 public:
  static constexpr long kWindow = 256;      // steps that are checked together
  static constexpr double kUneven = 1.15;   // most / mean of a window, from where on it counts: disturbances are less
  static constexpr int kWindowsInARow = 2;  // uneven windows in a row before a partition: one alone is chance

  // By rank, own work in the last window, s, and what that was estimated to be, in any unit. The same on all ranks,
  // and so is what follows from it.
  bool is_worth_dividing(std::span<const double> seconds, std::span<const double> estimated);
  // Ratio in the uneven windows until now, by rank; 1: as over all ranks together.
  std::vector<double> measured_over_estimated() const;
  void divided(double seconds);                    // all that it took
  void costs(double seconds) { cost_ = seconds; }  // before the first division

 private:
  void reset();

  std::vector<double> spent_, estimated_;  // by rank, in the uneven windows
  int in_a_row_ = 0;
  double lost_ = 0.0, cost_ = 0.0;  // time lost in them; cost of a partition, s
  double patience_ = 1.0;           // times that the cost must have been lost
};

}  // namespace quoin
