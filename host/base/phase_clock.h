// Time of a run by phase.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>

#include "base/clock.h"

namespace quoin {

enum class Phase {
  jumps,
  law,
  contact_forces,
  internal_forces,
  motion,
  detection,
  measurement,
  watch,
  output,
  ranks,
  members
};
inline constexpr std::size_t kPhases = 11;

// Wall-clock time by phase, s.
struct PhaseTimes {
  std::array<double, kPhases> seconds{};
  double& operator[](Phase phase) { return seconds[static_cast<std::size_t>(phase)]; }
  double operator[](Phase phase) const { return seconds[static_cast<std::size_t>(phase)]; }
};

// Times of one thread since start(), phase by phase. Threads do not share cache lines.
struct alignas(64) PhaseClock {
  PhaseTimes times;
  Clock::time_point last;

  void start() { last = Clock::now(); }
  void lap(Phase phase) {
    const auto now = Clock::now();
    times[phase] += std::chrono::duration<double>(now - last).count();
    last = now;
  }
};

// Ends a phase. Without a clock it does nothing, so that steps without timing have no cost.
inline void lap(PhaseClock* clock, Phase phase) {
  if (clock) clock->lap(phase);
}

}  // namespace quoin
