// Effect of damping on the first modes of vibration of a stage with ground motion, at its begin.
#pragma once

#include <string>
#include <vector>

namespace quoin {

struct StageModes {
  struct Mode {
    double frequency = 0.0, ratio = 0.0;  // Hz; of critical
  };
  int stage = 0;
  std::vector<Mode> modes;
  std::string why_none;  // reason why modes are not known; empty: they are
};

}  // namespace quoin
