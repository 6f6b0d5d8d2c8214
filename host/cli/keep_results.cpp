#include "cli/keep_results.h"

#include <fmt/format.h>
#include <unistd.h>

#include <future>
#include <string>

#include "cli/process_seconds.h"
#include "files/gnuplot.h"
#include "law/law_calls.h"
#include "results/block_picture.h"
#include "results/checkpoint_file.h"
#include "results/crushed_out.h"
#include "results/plots.h"
#include "results/provenance.h"
#include "results/quasi_static.h"
#include "results/report.h"
#include "results/warnings.h"
#include "step/collect.h"
#include "step/findings.h"
#include "step/large_motion.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

// Notice of a picture. An error in a picture must not end a run.
template <class Draw>
std::string notice_of(const Draw& draw) {
  try {
    return draw();
  } catch (const std::exception& error) {
    return fmt::format("a picture is missing: {}", error.what());
  }
}

// Whether pictures show blocks of any shape, not bricks.
bool shows_blocks(const Simulation& simulation) { return simulation.large_motion() || simulation.scene().blocks; }

// Gathers the blocks of pictures on rank 0, unless they are too many. Collective.
void gather_for_pictures(Simulation& simulation) {
  if (simulation.scene().output.plots && shows_blocks(simulation) && simulation.block_count() <= kMostBlocks)
    gather_at_first(simulation);
}

// Draws curve.png, cracks.png, mechanism.png, histories.png, base_shear.png and drifts.png. Prints a notice for each
// missing one.
void draw(const fs::path& folder, const Simulation& simulation, const Surfaces& surfaces, const RunInfo& info,
          const RunOptions& options, Recorder& recorder) {
  const auto& rows = recorder.history().rows();
  const std::string label = warning_label(info.warnings), law = law_names(simulation.assembly());
  // Each runs gnuplot in a process of its own.
  const auto notice_of_rows = [&](const char* picture, const auto& plot) {
    // gnuplot fails at a file without a point.
    return rows.empty() ? fmt::format("no {}: the history has no row, so there is nothing to draw", picture)
                        : notice_of(plot);
  };
  auto curve = std::async(std::launch::async | std::launch::deferred, [&] {
    return notice_of_rows("curve.png", [&] { return plot_curve(folder, rows, simulation.scene(), law, label); });
  });
  std::string of_cracks, of_mechanism, of_histories, of_shear, of_drifts;
  if (options.histories) {
    const Scene& scene = simulation.scene();
    of_histories = notice_of_rows("histories.png", [&] { return plot_histories(folder, rows, scene, label); });
    of_shear = notice_of([&] { return plot_base_shear(folder, rows, scene, label); });
    if (recorder.monitors())
      of_drifts = notice_of([&] { return plot_drifts(folder, recorder.monitors()->storey_drifts(), scene, label); });
  }
  if (!info.law_answers) {
    of_cracks = "no cracks.png: the law no longer tells the states of contact points";
  } else if (shows_blocks(simulation)) {
    of_mechanism = notice_of([&] { return plot_mechanism(folder, simulation, rows, label); });
    of_cracks = notice_of([&] { return plot_block_cracks(folder, simulation, surfaces, rows, label); });
  } else {
    of_cracks = notice_of([&] { return plot_cracks(folder, simulation, surfaces, rows, law, label); });
  }
  for (const std::string& notice : {curve.get(), of_cracks, of_mechanism, of_histories, of_shear, of_drifts}) {
    if (!notice.empty()) recorder.progress().message("quoin: " + notice);
  }
  for (const char* name : {"curve", "cracks", "mechanism", "histories", "base_shear", "drifts"}) {
    if (!options.svg || !fs::exists(folder / (std::string(name) + ".png"))) continue;
    const std::string notice = notice_of([&] { return draw_as_svg(folder, name); });
    if (!notice.empty()) recorder.progress().message("quoin: " + notice);
  }
}

}  // namespace

void keep_results(const fs::path& folder, Simulation& simulation, const Surfaces& surfaces, const RunOptions& options,
                  const std::optional<Error>& failure, Recorder& recorder, RunInfo& info, int& exit_code) {
  const auto keep = [&](const auto& write) {
    try {
      write();
    } catch (const Error& error) {
      recorder.progress().message(fmt::format("quoin: {}", error.what()));
      if (exit_code == 0) exit_code = static_cast<int>(error.exit_code);
    }
  };
  const OutputSettings& output = simulation.scene().output;
  const auto& rows = recorder.history().rows();
  const bool has_all = !failure || ranks_together(simulation);  // otherwise rank 0 has only its own blocks
  info.law_answers = laws_answer(simulation);
  if (failure) {
    info.status = failure->exit_code == Exit::interrupted ? "interrupted" : "failed";
    info.message = failure->what();
    exit_code = static_cast<int>(failure->exit_code);
  }
  if (recorder.frames_fault() && exit_code == 0) exit_code = static_cast<int>(recorder.frames_fault()->exit_code);
  keep([&] { recorder.finish_tables(); });
  keep([&] {
    if (!simulation.scene().has_frames()) return;
    const bool shows_end = failure && has_all && info.law_answers;
    if (shows_end && recorder.frames_fault()) collect_frame(simulation, surfaces);
    if (shows_end && !recorder.frames_fault()) recorder.frames().add_frame(simulation);
    recorder.frames().finish();
  });
  info.quasi_static = check_quasi_static(rows, simulation.scene());
  if (info.law_answers && has_all) info.crushed_out = find_crushed_out(simulation);
  info.warnings = warnings_of(simulation, info.quasi_static, info.crushed_out);
  info.modes = recorder.modes();
  if (has_all) gather_for_pictures(simulation);
  stop_drawing = false;  // a signal that has ended the steps does not end the pictures
  if (output.plots && has_all) draw(folder, simulation, surfaces, info, options, recorder);
  const bool is_undrawn = stop_drawing && !failure;  // a signal has ended the pictures: --resume draws them
  if (is_undrawn && rank_traffic(simulation).empty()) recorder.on_pause(simulation, true);
  keep([&] { note_results(simulation, folder, &info.provenance); });
  bool end_is_missing = output.end_state && !failure;
  keep([&] {
    if (end_is_missing) write_end_state(folder, simulation, info.provenance);
    end_is_missing = false;
  });
  info.wall_clock_s = process_seconds();
  RunInfo kept = info;  // what --resume goes by
  if (is_undrawn) kept.status = "interrupted", kept.message = "stopped while its pictures were drawn";
  if (end_is_missing) kept.status = "failed", kept.message = "end_state.bin was not written";
  keep([&] { write_summary(folder / "summary.json", simulation, rows, kept); });
  keep([&] {
    if (options.report) write_report({folder});
  });
  std::error_code ignored;
  if (!failure && !is_undrawn && exit_code == 0)
    fs::remove(folder / "checkpoint.bin", ignored);  // not needed after the end of a run
  if (!is_undrawn) return;
  recorder.progress().message("quoin: interrupted while pictures were drawn; they are drawn by quoin run --resume " +
                              folder.string());
  if (exit_code == 0) exit_code = static_cast<int>(Exit::interrupted);
}

void collect_results(Simulation& simulation, const Surfaces& surfaces, bool failed) {
  const OutputSettings& output = simulation.scene().output;
  if (failed && simulation.scene().has_frames()) collect_frame(simulation, surfaces);
  find_crushed_out(simulation);
  gather_for_pictures(simulation);
  if (output.plots && !shows_blocks(simulation)) collect_cracks(simulation, surfaces);
  if (output.end_state && !failed) simulation.save({});
}

void end_with_law(const Material& material, const quoin_batch& batch, double seconds, const fs::path& folder,
                  const Simulation& simulation, Recorder& recorder, RunInfo info) {
  info.status = "failed";
  info.law_answers = false;
  info.message = overdue_text(simulation, material, batch, seconds) + "--law-seconds";
  recorder.progress().message("quoin: " + info.message);
  try {
    recorder.finish_tables();
    info.wall_clock_s = process_seconds();
    write_summary(folder / "summary.json", simulation, recorder.history().rows(), info);
    recorder.progress().message("quoin: what was computed is kept in " + folder.string());
  } catch (const std::exception& error) {
    recorder.progress().message(fmt::format("quoin: {}", error.what()));
  }
  _exit(static_cast<int>(Exit::numerical));
}

}  // namespace quoin
