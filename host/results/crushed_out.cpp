#include "results/crushed_out.h"

#include <fmt/format.h>

#include <algorithm>

#include "step/collect.h"
#include "step/results.h"

namespace quoin {

CrushedOut find_crushed_out(const Simulation& simulation) {
  CrushedOut found;
  // Counts exist already, while points are expensive.
  if (condition_counts(simulation)[static_cast<size_t>(Condition::crushed_out)] == 0) return found;
  for (const ResultRun& run : runs_of_points(simulation)) {
    if (!brings(simulation, run)) continue;
    for (const ContactPoint& p : contact_points(simulation, {run.first, run.end})) {
      if (p.condition != Condition::crushed_out) continue;
      ++found.points;
      found.overlap = std::max(found.overlap, -p.jump[0]);
    }
  }
  found.points = static_cast<long>(sum_brought(simulation, static_cast<double>(found.points)));
  found.overlap = largest_brought(simulation, found.overlap);
  return found;
}

std::string CrushedOut::warning() const {
  if (points == 0) return {};
  return fmt::format(
      "{} contact point{} crushed out: {} no more than the residual compressive strength, and blocks overlap there by "
      "up "
      "to {:.3g} mm; where that matters, as in a collapse, give the joints a compressive_strength_residual > 0",
      points, points == 1 ? " is" : "s are", points == 1 ? "it carries" : "they carry", overlap * 1e3);
}

}  // namespace quoin
