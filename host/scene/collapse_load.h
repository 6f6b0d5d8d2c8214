// Growth of the load of a collapse stage without a rate.
#pragma once

#include <cmath>
#include <optional>

#include "scene/scene.h"

namespace quoin {

// Share by which a load without a rate grows before it stands still until the blocks are at rest. So it is at most this
// share above a load that the blocks have carried.
inline constexpr double kCollapseGrowth = 0.005;

inline bool waits(const Collapse& c) { return !c.rate; }

// Time from the end of the ramp until the stage ends without collapse, s. None: the load has no rate, or limit analysis
// has not found its bounds.
inline std::optional<double> seconds_of_growth(const Collapse& c) {
  if (!c.start || !c.rate || !c.limit) return std::nullopt;
  return (*c.limit - *c.start) / *c.rate;
}

// Index of the highest load at or below the multiplier. Loads at which it stands still are start, start (1 + growth),
// and so on. -1: the multiplier is below the start.
inline int last_stop(double start, double multiplier) {
  constexpr double kRounding = 1e-9;
  if (multiplier < start * (1.0 - kRounding)) return -1;
  return static_cast<int>(std::floor(std::log(multiplier / start) / std::log1p(kCollapseGrowth) + kRounding));
}
inline double load_at(double start, int stop) { return start * std::pow(1.0 + kCollapseGrowth, stop); }

// Largest excess of the multiplier at collapse over the one that blocks carry for good. None: the load has a rate, or
// the multiplier is unknown.
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
