// A quantity given at some moments.
#pragma once

#include <algorithm>
#include <vector>

namespace quoin {

// Piecewise linear in time; constant beyond its ends. Empty: 1 always.
struct TimeSeries {
  std::vector<double> time, value;  // time in s, increasing

  double at(double t) const {
    if (time.empty()) return 1.0;
    if (t <= time.front()) return value.front();
    if (t >= time.back()) return value.back();
    const auto i = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
    const double f = (t - time[i - 1]) / (time[i] - time[i - 1]);
    return value[i - 1] + f * (value[i] - value[i - 1]);
  }

  // From time[0] to t of a record, which is 0 outside its times: ground velocity from ground acceleration. Exact.
  double integral(double t) const {
    double sum = 0.0;
    for (std::size_t i = 1; i < time.size() && time[i - 1] < t; ++i) {
      const double end = std::min(t, time[i]);
      sum += (end - time[i - 1]) * 0.5 * (value[i - 1] + at(end));
    }
    return sum;
  }
};

// TimeSeries::integral in little time, with the same bits.
class RunningIntegral {
 public:
  RunningIntegral() = default;
  explicit RunningIntegral(const TimeSeries& series) : until_(series.time.size(), 0.0) {
    for (std::size_t i = 1; i < until_.size(); ++i)
      until_[i] = until_[i - 1] + (series.time[i] - series.time[i - 1]) * 0.5 * (series.value[i - 1] + series.value[i]);
  }
  double at(const TimeSeries& series, double t) const {
    const auto& time = series.time;
    if (time.empty() || t <= time.front()) return 0.0;
    if (t >= time.back()) return until_.back();
    const auto i = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
    return until_[i - 1] + (t - time[i - 1]) * 0.5 * (series.value[i - 1] + series.at(t));
  }

 private:
  std::vector<double> until_;  // by sample
};

}  // namespace quoin
