// On which side of a monitor its joints are: the sign of the force that presses them goes by it.
#pragma once

#include <cmath>

namespace quoin {

class MonitorSide {
 public:
  // arm: height of a contact point over the centre of its block of the monitor, m.
  void add(double arm) {
    sum_ += arm;
    whole_ += std::abs(arm);
  }
  // As over a bottom beam. For blocks with joints above and below rounding decides nothing.
  bool joints_are_above() const { return sum_ > kMostly * whole_; }

 private:
  static constexpr double kMostly = 0.5;  // share of the arms, so that joints beside the centre do not count
  double sum_ = 0.0, whole_ = 0.0;
};

}  // namespace quoin
