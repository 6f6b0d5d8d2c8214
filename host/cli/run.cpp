#include "cli/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/any_error.h"
#include "cli/again.h"
#include "cli/follow.h"
#include "cli/keep_results.h"
#include "cli/print_results.h"
#include "cli/recorder.h"
#include "cli/resume.h"
#include "cli/run_begin.h"
#include "cli/stop_on_signal.h"
#include "files/file.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "law/law_calls.h"
#include "law/law_process.h"
#include "law/law_trial.h"
#include "ranks/join.h"
#include "results/monitors.h"
#include "step/damage_growth.h"
#include "step/findings.h"
#include "step/kernels.h"
#include "step/large_motion.h"
#include "step/rest.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

constexpr double kTogether = 5.0;  // s within which ranks that fail together have all failed

// Locks the folder of a run to be resumed, and reads its options. Null: the run is complete, and nothing was changed.
std::shared_ptr<FolderLock> take_folder(const fs::path& folder, RunOptions* options) {
  if (!fs::is_directory(folder))
    throw Error(Exit::bad_input, fmt::format("--resume {}: no such folder of results", folder.string()));
  if (is_done(folder)) return nullptr;
  auto lock = std::make_shared<FolderLock>(folder);
  if (is_done(folder)) return nullptr;  // another process has completed it in the meantime
  read_run_record(folder, options);
  return lock;
}

// Prints the settings of the run before its first step. resumed: by --resume; goes_on: from a checkpoint.
void say_what_begins(const RunOptions& options, const Simulation& simulation, const Ranks* ranks, int wanted_threads,
                     bool resumed, bool goes_on, Recorder& recorder) {
  const auto say = [&](const std::string& text) { recorder.progress().message(text); };
  const TimeStepReport& step = simulation.time_step_report();
  say(fmt::format(
      "{}: {} blocks and beams, {} zones, {} contact points; law {}; time step {:.3g} s ({:.2f} of 2/omega_max); {}{} "
      "threads, {}",
      options.scene.scene, simulation.block_count(), simulation.zone_count(), simulation.point_count(),
      law_names(simulation.assembly()), step.time_step, step.time_step / step.critical.value,
      ranks ? fmt::format("{} ranks of ", ranks->count()) : "", simulation.thread_count(), kernel_instruction_set()));

  const OutputSettings& output = simulation.scene().output;
  const bool has_frames = simulation.scene().has_frames();
  if (options.compressed && !has_frames)
    say("--compressed: without effect, as output.frames = 0 writes no files for ParaView");
  if (options.svg && !output.plots) say("--svg: without effect, as output.plots = false draws no pictures");
  if (options.histories && !output.plots) say("--histories: without effect, as output.plots = false draws no pictures");
  if (output.pieces && !has_frames) say("output.pieces: without effect, as output.frames = 0 writes no frames");
  if (output.pieces && has_frames && pieces_of(simulation.scene(), ranks).count <= 1)
    say("output.pieces: without effect in one process, which writes each frame as one file");
  if (simulation.thread_count() < wanted_threads)
    say(fmt::format(
        "quoin: warning: the machine started {} threads of the {} wanted (ulimit -u, ulimit -v); the run takes longer",
        simulation.thread_count(), wanted_threads));
  if (goes_on)
    say(fmt::format("resumed at step {}, {:.6g} s", simulation.step(), simulation.time()));
  else if (resumed)
    say("resumed before its first checkpoint: from the start");
  if (simulation.large_motion() && !simulation.scene().blocks && !simulation.outcome().promotion) {
    const bool at_once = simulation.scene().solver.large_motion == LargeMotion::always;
    say(at_once ? "large motion from the start" : "general kernels");
  }
  if (!step.warning().empty()) recorder.on_warning({"time_step", step.warning()});
  if (simulation.large_motion()) {
    for (const std::string& note : simulation.large_motion()->assembly.notes) say("quoin: " + note);
  }
}

// Checks free space before the run, as far as the size of results can be estimated.
void require_room(const fs::path& folder, const Simulation& simulation, const Surfaces& surfaces) {
  const Scene& scene = simulation.scene();
  const double growth = scene.output.frames_at_damage;
  double frames = 2.0, at_damage = 0.0;
  for (std::size_t i = 0; i < scene.stages.size(); ++i) {
    frames += scene.frames_in(i);
    if (scene.frames_follow_damage_in(i)) at_damage += kMostFramesAtDamage;
  }
  if (growth > 0.0) frames += std::min(at_damage, 1.0 / growth);  // damage is 1 at most
  require_space(folder, 1e6 + frames * (scene.has_frames() ? frame_bytes(simulation, surfaces) : 0.0),
                fmt::format("the results with output.frames = {}{}", scene.output.frames,
                            growth > 0.0 ? fmt::format(", frames_at_damage = {:g}", growth) : ""));
}

// The folder of results, and the earlier run in it.
struct RunFolder {
  fs::path folder;
  std::shared_ptr<FolderLock> lock;  // lock of a resumed run; null: a new run
  std::optional<Provenance> there;   // provenance of a repeated run
};

// Opens the folder, and sets options to those of a resumed or repeated run. Nothing: that run is complete, and nothing
// was changed.
std::optional<RunFolder> run_folder(RunOptions* options) {
  RunFolder run;
  run.folder = options->out.empty() ? fs::path("out") / fs::path(options->scene.scene).stem() : fs::path(options->out);
  if (!options->resume.empty()) {
    run.folder = fs::absolute(options->resume);
    run.lock = take_folder(run.folder, options);
    if (!run.lock) return std::nullopt;
  }
  if (!options->again.empty()) {
    run.there = read_provenance(options->again);
    options->again = fs::absolute(options->again);
    run.folder = fs::absolute(options->out.empty() ? folder_again(options->again) : run.folder);
    const bool force = options->scene.force;
    options->scene = options_of(*run.there);
    options->scene.force = force;
  }
  return run;
}

// Reads the checkpoint of a continued run and shares it with all ranks. If it is refused, throws Error on all ranks.
Checkpoint checkpoint_of(const fs::path& folder, bool goes_on, const Identity& identity, Ranks* ranks) {
  Checkpoint before;
  std::optional<Error> refused;
  try {
    if (goes_on) before = find_checkpoint(folder / "checkpoint.bin", identity);
  } catch (const Error& error) {
    refused = error;
    before.stored.is_refused = true;
  }
  if (ranks) ranks->share(std::as_writable_bytes(std::span(&before.stored, 1)));
  if (refused) throw *refused;
  return before;
}

// Runs the simulation to its end, writes and prints its results.
void run_and_keep(const fs::path& folder, Simulation& simulation, const Surfaces& surfaces, const RunOptions& options,
                  Recorder& recorder, RunInfo& info, int& exit_code) {
  std::optional<Error> failure;
  const LawWatchdog watchdog(options.law_seconds, [&](const Material& material, const quoin_batch& batch) {
    end_with_law(material, batch, options.law_seconds, folder, simulation, recorder, info);
  });
  const StopOnSignal guard(simulation);  // to the end of the block: a signal must not stop the writing of results
  try {
    simulation.run(recorder);
  } catch (const std::exception& error) {
    failure = any_error(error, "make the scene smaller", "the scene and the law");
  }
  keep_results(folder, simulation, surfaces, options, failure, recorder, info, exit_code);
  print_results(folder, simulation, recorder.history().rows(), info);
  for (const Warning& warning : info.warnings)
    if (!recorder.was_reported(warning)) recorder.on_warning(warning);
  if (failure) {
    recorder.progress().message(failure->exit_code == Exit::interrupted
                                    ? "quoin: interrupted; what was computed is kept in " + folder.string()
                                    : fmt::format("quoin: {}", failure->what()));
  }
}

void run(RunOptions options, Ranks* ranks, int& exit_code) {
  const std::optional<RunFolder> place = run_folder(&options);
  if (!place) {
    fmt::print("{0}: the run is done; nothing to resume{1}\n", options.resume,
               options.report ? "; its page: quoin report " + options.resume : "");
    return;
  }
  const auto& [folder, lock, there] = *place;
  if (options.law_seconds != kLawSeconds) law_loading_seconds = options.law_seconds;
  Scene scene = scene_of(&options, ranks);
  keep_start(scene, folder);
  const int wanted = threads_of(options, ranks);
  if (options.isolate_law) isolate_laws({wanted, options.law_seconds});
  std::optional<LawWatchdog> of_set_up(std::in_place, options.law_seconds,
                                       end_program(options.law_seconds, "--law-seconds"));
  Simulation simulation(std::move(scene), wanted, ranks);
  RunInfo info;
  info.provenance = provenance_of(simulation, {options.scene.law, options.scene.overrides});
  if (there) hold_against(info.provenance, *there);
  Identity identity = identity_of(simulation, info.provenance);
  const bool goes_on = lock && fs::exists(folder / "checkpoint.bin");
  const Checkpoint before = checkpoint_of(folder, goes_on, identity, ranks);
  begin(&simulation, folder, before.stored);
  say_what_is_missing(folder, before.results.frame_times.size());
  // What may refuse the run comes before results of an earlier one are removed.
  require_coming_stages(simulation);
  Surfaces surfaces;
  require_room(folder, simulation, surfaces);
  auto server = options.serve >= 0 ? std::make_unique<PageServer>(options.serve) : nullptr;
  // Removes results of an earlier run, so that those of a failed run are not mistaken for them.
  const ResultFolder own(folder, lock, [&, resumed = lock != nullptr](const std::string& name) {
    return resumed && is_kept(name, before.results.frame_times.size());
  });
  const Pieces pieces = pieces_of(simulation.scene(), ranks);
  if (pieces.count > 1) {  // other ranks write into the folder from here on
    SharedFolder shared{fs::absolute(folder).string(), part_token(), before.results.frame_times};
    share(*ranks, shared);
  }
  write_run_record(folder, options, simulation.scene().text);  // a resumed run may have more options

  Recorder recorder(folder, simulation, surfaces, std::move(identity), options.checkpoint_every, before.results,
                    options.compressed, pieces);
  const bool has_monitors = !simulation.scene().monitors.empty();
  if (has_monitors && ranks)
    recorder.progress().message("quoin: no monitors.csv, as no rank has all blocks; run it in one process for that");
  else if (has_monitors)
    recorder.follow(folder, simulation, before.results.monitor_rows);
  say_what_begins(options, simulation, ranks, wanted, lock != nullptr, goes_on, recorder);
  if (server) recorder.serve(std::move(server), folder, simulation);
  of_set_up.reset();
  run_and_keep(folder, simulation, surfaces, options, recorder, info, exit_code);
  if (there && info.status != "interrupted") {
    const bool same = say_whether_same(info.provenance, folder, *there, options.again);
    if (same && info.status == "failed") exit_code = 0;  // as the run there did
    if (!same && exit_code == 0) exit_code = static_cast<int>(Exit::numerical);
  }
  if (info.status != "done" && !ranks_together(simulation)) {
    std::fflush(stdout);
    ranks->abort(exit_code);
  }
}

}  // namespace

void run_on_ranks(const RunOptions& options, int& exit_code) {
  const std::unique_ptr<Ranks> ranks = join_ranks();
  if (!ranks) return run(options, nullptr, exit_code);
  notices_wanted = ranks->rank() == 0;
  if (options.serve >= 0)
    throw Error(Exit::usage, "--live, --serve: not with several ranks; run the scene in one process, or write frames");
  if (options.isolate_law)
    throw Error(Exit::usage,
                "--isolate-law: not with several ranks, which would each start processes that MPI does not know; run "
                "the law on one rank first");
  const auto end_alone = [&](Exit code, const std::string& text) {
    notices_wanted = true;
    notice(fmt::format("quoin: rank {}: {}", ranks->rank(), text));
    ranks->abort(static_cast<int>(code));
  };
  try {
    if (ranks->rank() == 0)
      run(options, ranks.get(), exit_code);
    else
      follow(options, *ranks, exit_code);
  } catch (const Error& error) {
    exit_code = static_cast<int>(error.exit_code);
    notice(fmt::format("quoin: {}", error.what()));  // message of rank 0
    if (!ranks->all_here(kTogether)) end_alone(error.exit_code, error.what());
  } catch (const std::exception& error) {
    const Error reported = any_error(error, "fewer ranks on each machine, or a smaller scene");
    end_alone(reported.exit_code, reported.what());
  }
}

}  // namespace quoin
