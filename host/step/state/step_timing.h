// Times of the phases of a run. Steps, and the functions between them, add to these.
#pragma once

#include <vector>

#include "base/clock.h"
#include "base/phase_clock.h"

namespace quoin {

// One step in kTimedSteps is timed phase by phase, which costs less than one percent. A prime: phases at round
// intervals, such as checks of motion, fall on timed steps as often as on others.
constexpr long kTimedSteps = 31;

struct StepTiming {
  bool every_step = false;
  double timed_steps = 0.0;  // number of steps for which this one's time stands; 0: not timed
  PhaseTimes phases;
  std::vector<PhaseClock> clocks;  // by thread

  void begin_step(long step) {
    timed_steps = every_step ? 1.0 : step % kTimedSteps == 0 ? static_cast<double>(kTimedSteps) : 0.0;
  }
  Clock::time_point now_if_timed() const { return timed_steps > 0.0 ? Clock::now() : Clock::time_point(); }
  PhaseClock* started_clock(int thread);  // null: this step is not timed
  void book(double wall);  // divides the wall time of a phase of work, s, by the threads' clocks, and resets these
};

}  // namespace quoin
