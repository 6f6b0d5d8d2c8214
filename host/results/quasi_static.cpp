#include "results/quasi_static.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "results/history.h"
#include "scene/driven.h"

namespace quoin {
namespace {

constexpr long kLeastRows = 10;  // least rows of a stage: fewer do not sample oscillating forces

// Whether a stage drives bodies slowly; ground motion does not count.
bool drives(const Stage& stage) {
  return !stage.ground &&
         (stage.displacement || stage.whiffletree || driven_along(stage) != std::array{false, false, false});
}

// Why the force on what a stage of blocks watches is not that of its drive; empty: it is.
std::string watches_another(const Stage& stage, const Scene& scene) {
  const std::string& watched = stage.monitor.empty() ? scene.output.monitor : stage.monitor;
  if (!scene.blocks || stage.whiffletree || watched.empty()) return "";
  std::string driven;
  for (const BodyControl& c : stage.controls) {
    if (driven_along(stage, {c.body}) == std::array{false, false, false}) continue;
    if (c.body == watched || watched.starts_with(c.body + "/") || c.body.starts_with(watched + "/")) return "";
    driven = c.body;
  }
  if (driven.empty()) return "";
  return fmt::format("stage '{}' drives '{}' and watches '{}', whose force is not that of the drive: watch the former",
                     stage.name, driven, watched);
}

struct MeanSquare {
  double sum = 0.0;
  long count = 0;
  void add(double x) {
    sum += x * x;
    ++count;
  }
  double root() const { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0; }
};

}  // namespace

QuasiStatic check_quasi_static(const std::vector<HistoryRow>& rows, const Scene& scene) {
  QuasiStatic result;
  result.driven = std::any_of(scene.stages.begin(), scene.stages.end(), drives);
  // most_work: largest magnitude at any time, as a closed cycle has none, and what is lowered takes up work
  double peak = 0.0, at_peak = 0.0, work = 0.0, most_work = 0.0, kinetic = 0.0;
  // Two means, as the force may be largest in the ramp, while quiet ramps must not hide what follows them.
  MeanSquare inertia, after_ramps;
  for (std::size_t first = 0, end = 0; first < rows.size(); first = end) {
    for (end = first; end < rows.size() && rows[end].stage == rows[first].stage;) ++end;
    const Stage& stage = scene.stages[static_cast<std::size_t>(rows[first].stage)];
    if (!drives(stage)) continue;
    if (const std::string other = watches_another(stage, scene); !other.empty()) {
      result.not_judged = other;
      return result;
    }
    for (std::size_t i = first; i < end; ++i) {
      if (const double force = std::abs(rows[i].resistance); force > peak) {
        peak = force;
        at_peak = std::max(std::abs(rows[i].dynamic_force), rows[i].monitor_inertia);
      }
      kinetic = std::max(kinetic, rows[i].kinetic_energy);
      inertia.add(rows[i].dynamic_force);
      if (rows[i].time - rows[first].time >= stage.ramp_time) after_ramps.add(rows[i].dynamic_force);
      if (i > first)
        work += 0.5 * (rows[i].resistance + rows[i - 1].resistance) * (rows[i].displacement - rows[i - 1].displacement);
      most_work = std::max(most_work, std::abs(work));
    }
    const HistoryRow& last = rows[end - 1];
    const auto is_number = [](const HistoryRow& row) {
      return std::isfinite(row.resistance) && std::isfinite(row.kinetic_energy) && std::isfinite(row.dynamic_force);
    };
    if (!std::all_of(&rows[first], &rows[first] + (end - first), is_number)) {
      result.not_judged = fmt::format("stage '{}' has forces or energies that are no numbers", stage.name);
      return result;
    }
    if (stage.displacement)
      result.overshoot_ratio =
          std::max(result.overshoot_ratio, std::abs(last.displacement) / *stage.displacement - 1.0);
    // The first row of a stage is that of its first step.
    if (last.time - rows[first].time < stage.ramp_time)
      result.not_judged = fmt::format(
          "stage '{}' ended inside its ramp of {:g} s: it never moved at its velocity; give a "
          "longer way, or a shorter ramp_time",
          stage.name, stage.ramp_time);
    else if (end - first < kLeastRows)
      result.not_judged =
          fmt::format("stage '{}' has {} rows, too few to judge by; give a shorter output.record_interval", stage.name,
                      end - first);
  }
  if (peak > 0.0) {
    result.dynamic_force_ratio = std::max(inertia.root(), after_ramps.root()) / peak;
    result.dynamic_force_at_peak = at_peak / peak;
  }
  const double whole = scene.wall && scene.wall->half_thickness ? 2.0 : 1.0;
  if (most_work > 0.0) result.kinetic_energy_ratio = kinetic * whole / most_work;
  if (!result.not_judged.empty()) return result;
  if (!result.driven)
    result.not_judged = "no stage drives a body";
  else if (inertia.count == 0)
    result.not_judged = "no stage that drives a body was reached";
  else if (!result.dynamic_force_ratio || !result.kinetic_energy_ratio)
    result.not_judged =
        std::ranges::any_of(scene.stages, [&](const Stage& s) { return drives(s) && watches_nothing(scene, s); })
            ? "no block is watched (output.monitor)"
            : "the force on what is watched did no work; watch what is driven (monitor)";
  return result;
}

bool QuasiStatic::quasi_static() const { return reason().empty(); }

std::string QuasiStatic::reason() const {
  std::string text;
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (!not_judged.empty()) add(not_judged);
  // The comparison fails for NaN, too.
  if (dynamic_force_ratio && !(*dynamic_force_ratio <= kAllowed))
    add(fmt::format("inertia carries {:.1f} % of the peak force (root of the mean square), allowed {:.0f} %",
                    100 * *dynamic_force_ratio, 100 * kAllowed));
  if (dynamic_force_at_peak && !(*dynamic_force_at_peak <= kAllowedAtPeak))
    add(fmt::format("inertia is {:.0f} % of the peak force when that is reached, allowed {:.0f} %",
                    100 * *dynamic_force_at_peak, 100 * kAllowedAtPeak));
  if (kinetic_energy_ratio && !(*kinetic_energy_ratio <= kAllowed))
    add(fmt::format("the kinetic energy reaches {} the work, allowed {:.0f} %",
                    *kinetic_energy_ratio > 10.0 ? fmt::format("{:.2g} times", *kinetic_energy_ratio)
                                                 : fmt::format("{:.1f} % of", 100 * *kinetic_energy_ratio),
                    100 * kAllowed));
  if (!(overshoot_ratio <= kAllowedOvershoot))
    add(fmt::format("a stage went {:.1f} % beyond the displacement it asks for, allowed {:.0f} %: its steps are large",
                    100 * overshoot_ratio, 100 * kAllowedOvershoot));
  return text;
}

std::string QuasiStatic::warning() const {
  if (!driven || quasi_static()) return {};
  std::string text = "not known to be quasi-static: " + reason();
  if (reason() == not_judged) return text;
  return text +
         ". Load more slowly (stage velocity, or solver.quality) or with less inertia (solver.mass_scaling), and "
         "compare";
}

}  // namespace quoin
