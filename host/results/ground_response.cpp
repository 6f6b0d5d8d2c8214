#include "results/ground_response.h"

#include <cmath>
#include <cstddef>

#include "results/history.h"

namespace quoin {

std::optional<GroundResponse> find_ground_response(const std::vector<HistoryRow>& rows, const Scene& scene) {
  GroundResponse found;
  for (const HistoryRow& row : rows) {
    const Stage& stage = scene.stages[static_cast<std::size_t>(row.stage)];
    if (!stage.ground) continue;
    found.axis = axis_of_response(stage);
    const auto along = static_cast<std::size_t>(found.axis);
    const double moved = std::abs(row.monitor_relative[along]), base = std::abs(row.base_force[along]);
    if (moved > found.displacement) found.displacement = moved, found.moved_at = row.time;
    if (base > found.base_force) found.base_force = base, found.sheared_at = row.time;
  }
  if (!(found.displacement > 0.0 && found.base_force > 0.0)) return std::nullopt;
  return found;
}

}  // namespace quoin
