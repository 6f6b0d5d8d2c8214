#include "results/crushed_out.h"

#include <fmt/format.h>

#include <algorithm>

namespace quoin {

CrushedOut find_crushed_out(const Simulation& simulation) {
  CrushedOut found;
  // Asked first, as it is known.
  if (simulation.condition_counts()[static_cast<size_t>(Condition::crushed_out)] == 0) return found;
  for (const Simulation::Run& run : simulation.runs_of_points()) {
    if (!simulation.brings(run)) continue;
    for (const ContactPoint& p : simulation.contact_points({run.first, run.end})) {
      if (p.condition != Condition::crushed_out) continue;
      ++found.points;
      found.overlap = std::max(found.overlap, -p.jump[0]);
    }
  }
  found.points = static_cast<long>(simulation.sum_of_ranks(static_cast<double>(found.points)));
  found.overlap = simulation.largest_of_ranks(found.overlap);
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
