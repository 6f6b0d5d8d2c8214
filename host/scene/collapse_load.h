// How the load of a collapse stage grows where it has no rate.
#pragma once

#include <cmath>
#include <optional>

#include "scene/scene.h"

namespace quoin {

// A load without a rate waits: it grows by this much of itself, then stands still until the blocks are at rest. So it
// is at most that much above a load that the blocks have carried.
inline constexpr double kCollapseGrowth = 0.005;

inline bool waits(const Collapse& c) { return !c.rate; }

// Time from the end of the ramp until the stage ends without collapse, s; none: it waits, or limit analysis has not
// found its loads.
inline std::optional<double> seconds_of_growth(const Collapse& c) {
  if (!c.start || !c.rate || !c.limit) return std::nullopt;
  return (*c.limit - *c.start) / *c.rate;
}

// Loads at which it stands still are start, start (1 + growth), and so on. The highest at or below the multiplier, and
// the lowest above it; -1: none, as the start is not reached.
inline int last_stop(double start, double multiplier) {
  constexpr double kRounding = 1e-9;
  if (multiplier < start * (1.0 - kRounding)) return -1;
  return static_cast<int>(std::floor(std::log(multiplier / start) / std::log1p(kCollapseGrowth) + kRounding));
}
inline double load_at(double start, int stop) { return start * std::pow(1.0 + kCollapseGrowth, stop); }

// By how much the multiplier at collapse may lie above the one that blocks carry for good. None: the load does not
// wait.
inline std::optional<double> collapse_lag(const Scene& scene, const std::optional<double>& multiplier) {
  for (auto stage = scene.stages.rbegin(); multiplier && stage != scene.stages.rend(); ++stage) {
    if (!stage->collapse || !waits(*stage->collapse) || !stage->collapse->start) continue;
    const double start = *stage->collapse->start;
    const int stop = last_stop(start, *multiplier * (1.0 - 1e-9));
    if (stop >= 0) return *multiplier - load_at(start, stop);
  }
  return std::nullopt;
}

}  // namespace quoin
