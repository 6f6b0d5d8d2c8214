#include "step/rank_balance.h"

#include <algorithm>
#include <numeric>

namespace quoin {

namespace {

double sum_of(std::span<const double> values) { return std::accumulate(values.begin(), values.end(), 0.0); }
double mean_of(std::span<const double> values) { return sum_of(values) / static_cast<double>(values.size()); }

}  // namespace

double most_over_mean(std::span<const double> values) {
  const double mean = mean_of(values);
  return mean > 0.0 ? *std::max_element(values.begin(), values.end()) / mean : 1.0;
}

bool RankBalance::is_worth_dividing(std::span<const double> seconds, std::span<const double> estimated) {
  if (most_over_mean(seconds) <= kUneven) {
    reset();
    patience_ = 1.0;
    return false;
  }
  spent_.resize(seconds.size(), 0.0), estimated_.resize(seconds.size(), 0.0);
  for (std::size_t r = 0; r < seconds.size(); ++r) spent_[r] += seconds[r], estimated_[r] += estimated[r];
  lost_ += *std::max_element(seconds.begin(), seconds.end()) - mean_of(seconds);
  return ++in_a_row_ >= kWindowsInARow && lost_ >= patience_ * cost_;
}

std::vector<double> RankBalance::measured_over_estimated() const {
  const double of_all = sum_of(spent_) / sum_of(estimated_);
  std::vector<double> ratio(spent_.size(), 1.0);
  for (std::size_t r = 0; r < ratio.size(); ++r) {
    if (spent_[r] > 0.0 && estimated_[r] > 0.0) ratio[r] = spent_[r] / estimated_[r] / of_all;
  }
  return ratio;
}

void RankBalance::divided(double seconds) {
  reset();
  cost_ = seconds;
  patience_ *= 2.0;  // reset when a window is even
}

void RankBalance::reset() {
  spent_.clear(), estimated_.clear();
  lost_ = 0.0, in_a_row_ = 0;
}

}  // namespace quoin
