// The side of a monitor on which its joints lie: it gives the sign of the vertical force, compression positive.
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
  // Whether joints lie above, as over a bottom beam. For blocks with joints above and below, rounding must not decide.
  bool joints_are_above() const { return sum_ > kMostly * whole_; }

 private:
  static constexpr double kMostly = 0.5;  // share of the sum of |arm|: joints beside the centre do not count
  double sum_ = 0.0, whole_ = 0.0;
};

}  // namespace quoin
