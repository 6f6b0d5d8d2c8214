// What the steps of a run take, phase by phase. Steps write it, and what goes on between them.
#pragma once

#include <chrono>
#include <vector>

#include "base/phase_clock.h"

namespace quoin {

// One step in so many is timed phase by phase: a percent of a step, and no more. A prime: what comes at round
// intervals, such as checks of motion, falls on timed steps as often as on others.
constexpr long kTimedSteps = 31;

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct StepTiming {
  bool every_step = false;
  double timed_steps = 0.0;  // number of steps that the time of this one stands for; 0: not timed
  PhaseTimes phases;
  std::vector<PhaseClock> clocks;  // by thread

  void begin_step(long step) {
    timed_steps = every_step ? 1.0 : step % kTimedSteps == 0 ? static_cast<double>(kTimedSteps) : 0.0;
  }
  Clock::time_point now_if_timed() const { return timed_steps > 0.0 ? Clock::now() : Clock::time_point(); }
  PhaseClock* started_clock(int thread);  // null: this step is not timed
  void book(double wall);                 // s, of all threads, by what their clocks say; they begin again
};

}  // namespace quoin
