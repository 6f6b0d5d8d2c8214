// A quantity as a function of time, by samples.
#pragma once

#include <algorithm>
#include <vector>

namespace quoin {

// Piecewise linear in time, constant beyond its ends. Empty: the constant 1.
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

  // Part of it from `start` to `until`, which lie in its times or beyond; its time begins at 0.
  TimeSeries part(double start, double until) const {
    TimeSeries part;
    const auto add = [&](double t, double v) { part.time.push_back(t - start), part.value.push_back(v); };
    const double first = std::max(start, time.front()), last = std::min(until, time.back());
    add(first, at(first));
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (time[i] > first && time[i] < last) add(time[i], value[i]);
    }
    add(last, at(last));
    return part;
  }

  // Integral from time[0] to t of a record that is 0 outside its times, such as ground velocity from acceleration.
  // Exact.
  double integral(double t) const {
    double sum = 0.0;
    for (std::size_t i = 1; i < time.size() && time[i - 1] < t; ++i) {
      const double end = std::min(t, time[i]);
      sum += (end - time[i - 1]) * 0.5 * (value[i - 1] + at(end));
    }
    return sum;
  }
};

// TimeSeries::integral from stored sums, with the same bits.
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
  std::vector<double> until_;  // integral up to each sample
};

}  // namespace quoin
