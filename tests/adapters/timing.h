// Nanoseconds for each contact point: the shortest of many short runs, on which other programs have little influence.
#pragma once

#include <algorithm>
#include <chrono>
#include <limits>

namespace quoin::tests {

template <class Call>
double nanoseconds(std::size_t points, const Call& call) {
  using Clock = std::chrono::steady_clock;
  const std::size_t repeats = std::max<std::size_t>(1, 400 / points);
  double best = std::numeric_limits<double>::infinity();
  // At least three runs, and no more than half a second of them.
  const auto end = Clock::now() + std::chrono::milliseconds(500);
  for (int run = 0; run < 3000 && (run < 3 || Clock::now() < end); ++run) {
    const auto start = Clock::now();
    for (std::size_t i = 0; i < repeats; ++i) call();
    const std::chrono::duration<double, std::nano> taken = Clock::now() - start;
    best = std::min(best, taken.count() / static_cast<double>(repeats * points));
  }
  return best;
}

}  // namespace quoin::tests
