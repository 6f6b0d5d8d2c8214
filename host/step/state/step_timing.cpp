#include "step/state/step_timing.h"

namespace quoin {

PhaseClock* StepTiming::started_clock(int thread) {
  if (timed_steps == 0.0) return nullptr;
  PhaseClock& clock = clocks[static_cast<std::size_t>(thread)];
  clock.start();
  return &clock;
}

void StepTiming::book(double wall) {
  PhaseTimes sum;
  double total = 0.0;
  for (PhaseClock& clock : clocks) {
    for (std::size_t k = 0; k < kPhases; ++k) sum.seconds[k] += clock.times.seconds[k], total += clock.times.seconds[k];
    clock.times = {};
  }
  for (std::size_t k = 0; k < kPhases && total > 0.0; ++k)
    phases.seconds[k] += timed_steps * wall * sum.seconds[k] / total;
}

}  // namespace quoin
