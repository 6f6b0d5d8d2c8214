#include "cli/print_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "cli/progress.h"
#include "files/notice.h"
#include "law/law_process.h"
#include "results/ground_response.h"
#include "results/history.h"
#include "results/plots.h"
#include "scene/collapse_load.h"
#include "scene/quality.h"
#include "step/findings.h"

namespace quoin {

namespace {

// Prints the cost of laws in separate processes.
void print_isolation(const Simulation& simulation) {
  for (const ContactFamily& family : simulation.model().families) {
    const LawProcess* const process = family.material->process();
    if (!process) continue;
    const LawProcessTimes t = process->times();
    const double way = t.seconds - t.in_law;
    fmt::print(
        "law of joint family '{}' in a process of its own: {} batches, {:.2f} s, of which {:.2f} s the law and "
        "{:.2f} s the way there and back, {:.1f} us a batch\n",
        family.name, t.batches, t.seconds, t.in_law, way,
        t.batches > 0 ? 1e6 * way / static_cast<double>(t.batches) : 0.0);
  }
}

void print_response(const std::vector<HistoryRow>& rows, const Scene& scene) {
  const std::optional<GroundResponse> response = find_ground_response(rows, scene);
  if (!response) return;
  fmt::print(
      "earthquake: {} moves {:.3f} mm along {} against the ground (at {:.3f} s), base {} {:.2f} kN (at {:.3f} s)\n",
      response->of, response->displacement * 1e3, response->axis.name, response->moved_at,
      response->axis.direction[1] != 0.0 ? "force" : "shear", response->base_force / 1e3, response->sheared_at);
}

// Largest force on the monitor, with what is known of its error.
std::string peak_text(const std::vector<HistoryRow>& rows, const Scene& scene, const RunInfo& info) {
  if (std::ranges::all_of(scene.stages, [&](const Stage& stage) { return watches_nothing(scene, stage); }))
    return fmt::format("no block is watched ({}); ", key_of_monitor(scene));
  const Peak peak = find_peak(rows, scene);
  const bool ends_at_rest = std::string_view(curve_kind(scene.stages.back())) == "rest";
  if (ends_at_rest && peak.force < 5.0) return "";  // 0.00 kN
  const std::string unknown = why_error_unknown(scene, info);
  const std::string error = unknown.empty() ? fmt::format("expected error at quality {}: {:.1f} % with these zones",
                                                          scene.quality, 100 * quality_named(scene.quality).peak_error)
                                            : "error not known: " + unknown;
  const bool rises = peak.row > 0 && peak.row + 1 == static_cast<int>(rows.size()) && !ends_at_rest;
  const std::string whose = watches_several(scene) ? " of the " + moved_part(scene, stage_of_curve(scene)) : "";
  return fmt::format("peak{} {:.2f} kN at {:.3f} mm{}{} ({}); ", whose, peak.force / 1e3, peak.displacement * 1e3,
                     is_vertical(scene) ? " upright" : "", rises ? ", still rising at the end" : "", error);
}

}  // namespace

void print_results(const std::filesystem::path& folder, const Simulation& simulation,
                   const std::vector<HistoryRow>& rows, const RunInfo& info) {
  if (const auto& multiplier = simulation.outcome().collapse_multiplier) {
    const auto lag = collapse_lag(simulation.scene(), multiplier);
    fmt::print("collapse multiplier {:.4f}{}\n", *multiplier,
               lag ? fmt::format("; the blocks have stood under {:.4f}, {:.1f} % less", *multiplier - *lag,
                                 100.0 * *lag / *multiplier)
                   : "");
  }
  const Scene& scene = simulation.scene();
  const bool shaken =
      std::any_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) { return s.ground.has_value(); });
  fmt::print("{}{} steps in {:.1f} s; results in {}\n", shaken ? "" : peak_text(rows, scene, info), simulation.step(),
             info.wall_clock_s, folder.string());
  if (shaken) print_response(rows, scene);
  if (shaken && !rows.empty() && rows.back().energies) {
    const DissipatedEnergy taken = dissipated_in_earthquake(rows, scene);
    const double all = taken.all();
    const auto share = [&](double part) { return 100.0 * part / all; };
    const std::string members =
        taken.members > 0.0 ? fmt::format("members {:.0f} %, ", share(taken.members)) : std::string();
    if (all > 0.0)
      fmt::print("dissipated in the earthquake {:.4g} J: damping {:.0f} %, {}joints {:.0f} %\n", all,
                 share(taken.damping), members, share(taken.joints));
  }
  fmt::print("{}\n", phases_text(phase_times(simulation), info.wall_clock_s));
  if (!rank_traffic(simulation).empty()) fmt::print("{}\n", ranks_text(rank_traffic(simulation)));
  print_isolation(simulation);
}

void print_motion_report(const std::filesystem::path& vtu, const std::string& what, const Scene& scene,
                         const std::vector<ShownMotion>& motions, bool one_way) {
  const std::string title = fmt::format("{}: {}", what, scene.title.empty() ? scene.file : scene.title);
  try {
    fmt::print("{}\n", write_motion_report(vtu, title, motions, one_way).string());
  } catch (const Error& error) {
    notice(fmt::format("quoin: no report.html: {}", error.what()));
  }
}

}  // namespace quoin
