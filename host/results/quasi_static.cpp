#include "results/quasi_static.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "results/history.h"

namespace quoin {

QuasiStatic check_quasi_static(const std::vector<HistoryRow>& rows, const Scene& scene) {
  double peak = 0.0, squares = 0.0, work = 0.0, kinetic = 0.0, stage_start = 0.0;
  long count = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Stage& stage = scene.stages[static_cast<std::size_t>(rows[i].stage)];
    if (i == 0 || rows[i].stage != rows[i - 1].stage) stage_start = rows[i].time;
    if (!stage.displacement) continue;
    const Response now = response(rows[i], stage);
    peak = std::max(peak, std::abs(now.horizontal_force));
    if (i > 0 && rows[i - 1].stage == rows[i].stage) {
      const Response before = response(rows[i - 1], stage);
      work += 0.5 * (now.horizontal_force + before.horizontal_force) * (now.displacement - before.displacement);
    }
    if (rows[i].time - stage_start < stage.ramp_time) continue;
    squares += rows[i].dynamic_force * rows[i].dynamic_force;
    kinetic = std::max(kinetic, rows[i].kinetic_energy);
    ++count;
  }
  QuasiStatic result;
  if (count > 0 && peak > 0.0) result.dynamic_force_ratio = std::sqrt(squares / static_cast<double>(count)) / peak;
  if (work > 0.0) result.kinetic_energy_ratio = kinetic * (scene.wall && scene.wall->half_thickness ? 2.0 : 1.0) / work;
  return result;
}

std::string QuasiStatic::warning() const {
  if (quasi_static()) return {};
  return fmt::format(
      "not quasi-static: inertia carries {:.1f} % of the peak force (root of the mean square), the kinetic energy "
      "reaches "
      "{:.1f} % of the work; allowed {:.0f} %. Load more slowly (stage velocity, or solver.quality) and compare",
      100 * dynamic_force_ratio, 100 * kinetic_energy_ratio, 100 * kAllowed);
}

}  // namespace quoin
