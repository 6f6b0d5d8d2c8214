// Response to ground motion.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "results/history.h"
#include "step/simulation.h"

namespace quoin {

// Largest motion of the monitor against the ground, and largest force on the base, along the axis of the response.
// Absolute values in the rows of the last stages with ground motion that watch one part along one axis.
struct GroundResponse {
  std::string of;                             // name of what is watched
  ResponseAxis axis;                          // direction of both
  double displacement = 0.0, moved_at = 0.0;  // m, s
  double base_force = 0.0, sheared_at = 0.0;  // N, s
};
// Nothing: no stage moves the ground, or nothing is watched.
std::optional<GroundResponse> find_ground_response(const std::vector<HistoryRow>& rows, const Scene& scene);

}  // namespace quoin
