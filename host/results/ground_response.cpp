#include "results/ground_response.h"

#include <cmath>
#include <cstddef>
#include <string>

#include "results/history.h"
#include "results/plots.h"

namespace quoin {

std::optional<GroundResponse> find_ground_response(const std::vector<HistoryRow>& rows, const Scene& scene) {
  GroundResponse found;
  for (const HistoryRow& row : rows) {
    const Stage& stage = scene.stages[static_cast<std::size_t>(row.stage)];
    if (!stage.ground) continue;
    const int axis = axis_of_response(stage);
    const std::string of = moved_part(scene, stage);
    if (axis != found.axis || of != found.of) found = GroundResponse{.of = of, .axis = axis};
    const auto along = static_cast<std::size_t>(axis);
    const double moved = std::abs(row.monitor_relative[along]), base = std::abs(row.base_force[along]);
    if (moved > found.displacement) found.displacement = moved, found.moved_at = row.time;
    if (base > found.base_force) found.base_force = base, found.sheared_at = row.time;
  }
  if (!(found.displacement > 0.0 && found.base_force > 0.0)) return std::nullopt;
  return found;
}

}  // namespace quoin
