// How the load of a collapse stage grows where no rate is given, and where limit analysis says at what it begins.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "scene/scene.h"

namespace quoin {

// Collapse::start of a stage with start = "limit", until limit analysis has found it (analysis/collapse_start.h).
inline constexpr double kStartAtLimit = -1.0;
// Collapse::limit that follows from limit analysis, too.
inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();
// Collapse::rate of a load that waits: it grows by kCollapseGrowth of itself, then stands still until the blocks are at
// rest. So it is at most that much above a load that the blocks have carried.
inline constexpr double kWaits = 0.0;
inline constexpr double kCollapseGrowth = 0.005;

inline bool starts_at_limit(const Collapse& c) { return c.start == kStartAtLimit; }
inline bool waits(const Collapse& c) { return c.rate == kWaits; }

// Loads at which it stands still are start, start (1 + growth), and so on. The highest at or below the multiplier, and
// the lowest above it; -1: none, as the start is not reached.
inline int last_stop(const Collapse& c, double multiplier) {
  constexpr double kRounding = 1e-9;
  if (multiplier < c.start * (1.0 - kRounding)) return -1;
  return static_cast<int>(std::floor(std::log(multiplier / c.start) / std::log1p(kCollapseGrowth) + kRounding));
}
inline double load_at(const Collapse& c, int stop) { return c.start * std::pow(1.0 + kCollapseGrowth, stop); }

// By how much the multiplier at collapse may lie above the one that blocks carry for good. None: the load does not
// wait.
inline std::optional<double> collapse_lag(const Scene& scene, const std::optional<double>& multiplier) {
  for (auto stage = scene.stages.rbegin(); multiplier && stage != scene.stages.rend(); ++stage) {
    if (!stage->collapse || !waits(*stage->collapse)) continue;
    const int stop = last_stop(*stage->collapse, *multiplier * (1.0 - 1e-9));
    if (stop >= 0) return *multiplier - load_at(*stage->collapse, stop);
  }
  return std::nullopt;
}

}  // namespace quoin
