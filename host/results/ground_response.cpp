#include "results/ground_response.h"

#include <cmath>
#include <cstddef>
#include <string>

#include "results/history.h"
#include "results/plots.h"

namespace quoin {

std::optional<GroundResponse> find_ground_response(const std::vector<HistoryRow>& rows, const Scene& scene) {
  GroundResponse found;
  const Stage* last = nullptr;
  for (const HistoryRow& row : rows) {
    const Stage& stage = scene.stages[static_cast<std::size_t>(row.stage)];
    if (!stage.ground) continue;
    if (!last || !same_curve(scene, stage, *last))
      found = GroundResponse{.of = moved_part(scene, stage), .axis = response_axis(stage)};
    last = &stage;
    const Vec3& along = found.axis.direction;
    const double moved = std::abs(dot(row.monitor_relative, along)), base = std::abs(dot(row.base_force, along));
    if (moved > found.displacement) found.displacement = moved, found.moved_at = row.time;
    if (base > found.base_force) found.base_force = base, found.sheared_at = row.time;
  }
  if (!(found.displacement > 0.0 && found.base_force > 0.0)) return std::nullopt;
  return found;
}

}  // namespace quoin
