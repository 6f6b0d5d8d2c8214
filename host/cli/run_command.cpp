#include "cli/run_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <numeric>
#include <optional>
#include <set>
#include <thread>

#ifdef QUOIN_MODES
#include "analysis/damping_ratios.h"
#endif
#include "base/any_error.h"
#include "cli/again.h"
#include "cli/live_run.h"
#include "cli/prepare.h"
#include "cli/progress.h"
#include "cli/resume.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "files/notice.h"
#include "files/result_folder.h"
#include "law/law_calls.h"
#include "law/law_process.h"
#include "law/law_trial.h"
#include "ranks/join.h"
#include "results/block_picture.h"
#include "results/history.h"
#include "results/monitors.h"
#include "results/plots.h"
#include "results/quasi_static.h"
#include "results/report.h"
#include "results/summary.h"
#include "results/surface.h"
#include "results/vtk.h"
#include "scene/collapse_load.h"
#include "scene/damping_text.h"
#include "scene/quality.h"
#include "scene/rest_scene.h"
#include "step/large_motion.h"
#include "step/simulation.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;

std::atomic<Simulation*> running{nullptr};

extern "C" void stop_running(int) {
  if (Simulation* simulation = running.load()) simulation->request_stop();
}

// Ctrl-C asks the simulation to stop. A terminal that closes, a closed pipe of our output, and SIGUSR1 do so, too.
// SIGUSR1 is handed on by mpirun, which follows SIGTERM by SIGKILL within a second. A second time ends the program at
// once; but a reader that is gone will be written to again.
class StopOnSignal {
 public:
  explicit StopOnSignal(Simulation& simulation) {
    running = &simulation;
    for (std::size_t i = 0; i < kSignals.size(); ++i) {
      sigaction(kSignals[i], nullptr, &before_[i]);
      const bool of_terminal = kSignals[i] == SIGHUP || kSignals[i] == SIGPIPE;
      if (of_terminal && before_[i].sa_handler == SIG_IGN) continue;  // nohup
      struct sigaction action {};
      action.sa_handler = stop_running;
      action.sa_flags = SA_RESTART | (kSignals[i] == SIGPIPE ? 0 : static_cast<int>(SA_RESETHAND));
      sigaction(kSignals[i], &action, nullptr);
    }
  }
  ~StopOnSignal() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
    running = nullptr;
  }
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};
  std::array<struct sigaction, kSignals.size()> before_{};
};

// Since the start of the process, loading of libraries included.
double process_seconds() {
  static const auto at_main = std::chrono::steady_clock::now();
  static const double before = [] {
    // Field 22 of /proc/self/stat: start time in clock ticks since boot.
    std::ifstream stat("/proc/self/stat"), uptime("/proc/uptime");
    std::string text;
    std::getline(stat, text);
    const size_t bracket = text.rfind(')');
    double up = 0.0, start = 0.0;
    if (bracket == std::string::npos || !(uptime >> up)) return 0.0;
    std::istringstream fields(text.substr(bracket + 2));
    std::string skipped;
    for (int field = 3; field < 22; ++field) fields >> skipped;
    if (!(fields >> start)) return 0.0;
    return std::max(0.0, up - start / static_cast<double>(sysconf(_SC_CLK_TCK)));
  }();
  return before + std::chrono::duration<double>(std::chrono::steady_clock::now() - at_main).count();
}

constexpr double kTogether = 5.0;  // s, within which ranks that fail together have all failed

struct RunOptions {
  SceneOptions scene;
  std::string out;
  std::string resume;  // folder of the run that goes on; empty: a new one
  std::string again;   // folder of the run that is repeated; empty: none
  double checkpoint_every = 60.0;
  int threads = 0;
  bool report = false, svg = false, histories = false, compressed = false;
  bool isolate_law = false;
  double law_seconds = kLawSeconds;  // for one batch; 0: any time
  int serve = -1;                    // port of a page of the run while it goes on; 0: any, < 0: none
};

// Takes what the simulation reports: rows to the history, frames to VTK, progress to the terminal; and checkpoints.
class Recorder : public Observer {
 public:
  // before: what the run that goes on has recorded.
  Recorder(const fs::path& folder, const Simulation& simulation, Surfaces& surfaces, Identity identity,
           double checkpoint_every, const Checkpoint& before, bool compressed, Pieces pieces)
      : scene_(simulation.scene()),
        surfaces_(surfaces),
        history_(folder / "history.csv", simulation, before.rows),
        frames_(folder, surfaces, before.frame_times, compressed, pieces),
        checkpoint_(folder / "checkpoint.bin"),
        identity_(std::move(identity)),
        clock_(checkpoint_every) {
    for (const HistoryRow& row : before.rows) take(row);
  }

  void on_stage_begin(const Simulation& simulation, int stage) override {
    const Stage& s = scene_.stages[static_cast<size_t>(stage)];
    std::string text = fmt::format("stage {}/{} {}: until {}", stage + 1, scene_.stages.size(), s.name, end_of(s));
    if (s.ground) text += "; ground motion, " + ground_text(*s.ground);
    const TimeStepReport& step = simulation.time_step_report();
    if (const std::string own = own_solver_text(scene_, static_cast<size_t>(stage)); !own.empty())
      text += fmt::format("; {}: time step {:.3g} s ({:.2f} of 2/omega_max)", own, step.time_step,
                          step.time_step / step.critical.value);
    const SolverSettings& solver = scene_.solver_in(static_cast<size_t>(stage));
    const double in_use = step.impacts.in_use;
    if (in_use > 0.0 && in_use < 0.99 * solver.impact_damping)
      text += fmt::format(", at which {:.2g} of the impact damping of {:g} is in use", in_use, solver.impact_damping);
    if (in_use > 0.0)
      text += fmt::format("; an edge that lands comes back with {:.2g} of its velocity", landing_restitution(in_use));
    progress_.message(text);
#ifdef QUOIN_MODES
    if (!s.ground) return;
    const bool goes_on = !history_.rows().empty() && history_.rows().back().stage == stage;
    modes_.push_back(goes_on ? StageModes{stage, {}, "the run was resumed in this stage"}
                             : damped_modes(simulation, stage));
    progress_.message(modes_text(modes_.back()));
#endif
  }
  void on_law_swap(const LawSwap& swap) override {
    progress_.message(
        fmt::format("joint family '{}': law {} replaced by {} at {} contact points, tractions kept; stored "
                    "energy {:.6g} J, jump {:+.3g} J{}",
                    swap.family, swap.from, swap.to, swap.points, swap.stored_before, swap.energy_jump,
                    swap.limited ? fmt::format("; {} softened points come in intact", swap.limited) : ""));
  }
  void on_warning(const Warning& warning) override {
    reported_.insert(warning.about);
    progress_.message("quoin: warning: " + warning.text);
  }
  void on_promotion(const Simulation& simulation) override {
    const Promotion& p = *simulation.outcome().promotion;
    progress_.message(
        fmt::format("{}. On in large motion from step {}, {:.6g} s: {} contact points with their tractions and states, "
                    "strain energy {:.6g} J, jump {:+.3g} J; time step {:.3g} s",
                    p.why, p.step, p.time, simulation.point_count(), p.strain_energy, p.energy_jump,
                    simulation.time_step_report().time_step));
    surfaces_ = Surfaces();
  }
  void on_row(const HistoryRow& row) override {
    history_.add(row);
    if (monitors_) monitors_->add(row);
    take(row);
    if (live_) live_->add_row(row);
  }
  // Shows the run while it goes on: what it has come to so far, and from now on.
  void serve(int port, const fs::path& folder, const Simulation& simulation) {
    simulation_ = &simulation;
    live_ = std::make_unique<LiveRun>(port, folder, simulation, history_.rows(), frames_.times());
    progress_.message("the run goes on at " + live_->address());
  }
  void follow(const fs::path& folder, const Simulation& simulation, std::vector<Monitor> monitors,
              const std::vector<std::vector<double>>& before) {
    monitors_.emplace(folder, simulation, std::move(monitors), before);
  }
  void finish_tables() {
    history_.finish();
    if (monitors_) monitors_->finish();
  }
  bool wants_pause(bool last) override { return clock_.due() || (last && clock_.on()); }
  void on_pause(const Simulation& simulation, bool) override {
    if (monitors_) monitors_->flush();
    try {
      write_checkpoint(checkpoint_, identity_, history_.rows(), frames_.times(), simulation);
    } catch (const Error& error) {  // the run itself goes on, and what it has kept so far stays
      std::error_code unknown;
      if (const fs::path folder = checkpoint_.parent_path(); !fs::exists(folder, unknown) && !unknown)
        throw Error(Exit::bad_input,
                    fmt::format("{}: the folder has gone, and with it what was computed: nothing can be kept, so the "
                                "run ends here; run it again, with --out where nobody removes it",
                                folder.string()));
      progress_.message(fmt::format("quoin: warning: no checkpoint: {}", error.what()));
    }
    clock_.taken();
  }
  void on_progress(const Progress& progress) override {
    if (live_) {
      so_far_.cracked = cracked_share(*simulation_);
      live_->show(progress, so_far_);
    }
    progress_.show(progress, so_far_);
  }
  void on_frame(const Simulation& simulation, int, int) override {
    if (frames_fault_) return frames_.leave_out(simulation);
    try {
      frames_.add_piece(simulation);
      if (live_) live_->add_frame(simulation, history_.rows());
    } catch (const Error& error) {  // the run goes on without
      frames_fault_ = error;
      progress_.message(fmt::format("quoin: warning: no more frames for ParaView: {}", error.what()));
    }
  }
  void on_stage_end(const Simulation& simulation, int stage, const HistoryRow& last) override {
    const Response r = response(last, scene_.stages[static_cast<size_t>(stage)]);
    progress_.message(
        fmt::format("stage {}/{} done after {} steps: {:.3f} mm{}, horizontal {:.2f} kN, vertical {:.2f} kN, "
                    "unbalanced ratio {:.1e}",
                    stage + 1, scene_.stages.size(), simulation.step(), shown(last, scene_).displacement * 1e3,
                    is_vertical(scene_) ? " upright" : "", r.horizontal_force / 1e3, r.vertical_force / 1e3,
                    last.unbalanced_ratio));
    for (const StopAtForceLoss& stop : simulation.outcome().force_losses) {
      if (stop.stage == stage)
        progress_.message(
            fmt::format("stopped at force loss: half cycle {} reached {:.2f} kN, {:.2f} of {:.2f} kN before",
                        stop.half_cycle + 1, stop.force / 1e3, stop.force / stop.largest, stop.largest / 1e3));
    }
  }

  // By this process, or by the one that it goes on from.
  bool was_reported(const Warning& warning) const { return reported_.contains(warning.about); }
  History& history() { return history_; }
  VtkSeries& frames() { return frames_; }
  const std::optional<Error>& frames_fault() const { return frames_fault_; }
  const std::vector<StageModes>& modes() const { return modes_; }
  ProgressLine& progress() { return progress_; }

 private:
  void take(const HistoryRow& row) {
    const Shown now = shown(row, scene_);
    so_far_.displacement = now.displacement, so_far_.force = now.force;
    so_far_.kinetic_energy = row.kinetic_energy;
    if (std::abs(now.force) > std::abs(so_far_.peak))
      so_far_.peak = now.force, so_far_.displacement_at_peak = now.displacement;
  }
  // Of contact points: those that are not as they were, elastic or dry.
  static double cracked_share(const Simulation& simulation) {
    const auto counts = simulation.condition_counts();
    const long all = std::accumulate(counts.begin(), counts.end(), 0L);
    const long elastic = counts[static_cast<std::size_t>(Condition::elastic)];
    return all > 0 ? static_cast<double>(all - elastic) / static_cast<double>(all) : 0.0;
  }

  const Scene& scene_;
  Surfaces& surfaces_;
  History history_;
  std::optional<MonitorFile> monitors_;
  VtkSeries frames_;
  ProgressLine progress_;
  fs::path checkpoint_;
  Identity identity_;
  CheckpointClock clock_;
  RunSoFar so_far_;
  const Simulation* simulation_ = nullptr;  // that is served
  std::unique_ptr<LiveRun> live_;           // null: nobody looks
  std::set<std::string> reported_;
  std::vector<StageModes> modes_;  // of stages that move the ground
  std::optional<Error> frames_fault_;
};

// The notice of a picture: it is no reason to lose a run.
template <class Draw>
std::string notice_of(const Draw& draw) {
  try {
    return draw();
  } catch (const std::exception& error) {
    return fmt::format("a picture is missing: {}", error.what());
  }
}

// Holds the folder of the run that goes on and reads what it was asked for. Null: it is done, and nothing was touched.
std::shared_ptr<FolderLock> take_folder(const fs::path& folder, SceneOptions* scene) {
  if (!fs::is_directory(folder))
    throw Error(Exit::bad_input, fmt::format("--resume {}: no such folder of results", folder.string()));
  if (is_done(folder)) return nullptr;
  auto lock = std::make_shared<FolderLock>(folder);
  if (is_done(folder)) return nullptr;  // by now: another process has just finished it
  const bool force = scene->force;
  *scene = read_run_record(folder);
  scene->force = force;
  return lock;
}

// From the thread that watches, while another one never returns from the law. What was computed is kept, as far as the
// law is not called for it.
[[noreturn]] void end_with_law(const Material& material, const quoin_batch& batch, double seconds,
                               const fs::path& folder, const Simulation& simulation, Recorder& recorder, RunInfo info) {
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

// What processes of their own have cost the laws.
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

int threads_of(const RunOptions& options, const Ranks* ranks) {
  const int here = static_cast<int>(std::thread::hardware_concurrency());
  if (options.threads > 0) return options.threads;
  return std::max(1, ranks ? here / ranks->count_on_this_machine() : here);
}

// Of rank 0, to all others. Bytes: a vector of them, or text.
template <class Bytes>
void share_bytes(Ranks& ranks, Bytes& bytes) {
  std::uint64_t size = bytes.size();
  ranks.share(std::as_writable_bytes(std::span(&size, 1)));
  bytes.resize(size);
  ranks.share(std::as_writable_bytes(std::span(bytes)));
}

// What the others need to write files of their own into the folder of results: where it is, and the token of its
// manifest. The frames that are there.
struct SharedFolder {
  std::string path, token;
  std::vector<double> frame_times;
};

void share(Ranks& ranks, SharedFolder& folder) {
  share_bytes(ranks, folder.path), share_bytes(ranks, folder.token), share_bytes(ranks, folder.frame_times);
}

// All that the ranks beside rank 0 do, which alone speaks and writes: all but their pieces of frames.
class Follower : public Observer {
 public:
  Follower(const SharedFolder& folder, bool compressed, Pieces pieces) {
    if (pieces.count > 1) frames_.emplace(folder.path, surfaces_, folder.frame_times, compressed, pieces);
  }
  bool wants_pause(bool) override { return false; }
  void on_pause(const Simulation& simulation, bool) override { simulation.save({}); }  // what rank 0 asks for
  void on_promotion(const Simulation&) override { surfaces_ = Surfaces(); }
  void on_frame(const Simulation& simulation, int, int) override {
    if (!frames_) return collect_frame(simulation, surfaces_);
    if (fault_) return;
    try {
      frames_->add_piece(simulation);
    } catch (const Error& error) {  // the run goes on without
      fault_ = error;
    }
  }
  const std::optional<Error>& fault() const { return fault_; }
  const Surfaces& surfaces() const { return surfaces_; }

 private:
  Surfaces surfaces_;
  std::optional<VtkSeries> frames_;  // in pieces
  std::optional<Error> fault_;
};

// Of frames; one process alone writes all of them.
Pieces pieces_of(const Scene& scene, const Ranks* ranks) {
  if (!ranks || !scene.output.pieces || !scene.has_frames()) return {};
  return {ranks->rank(), ranks->count()};
}

// Pictures of blocks, not of bricks.
bool shows_blocks(const Simulation& simulation) { return simulation.large_motion() || simulation.scene().blocks; }

// So that rank 0 has what its pictures show, where that is little. By all ranks.
void gather_for_pictures(Simulation& simulation) {
  if (simulation.scene().output.plots && shows_blocks(simulation) && simulation.block_count() <= kMostBlocks)
    simulation.gather_at_first();
}

// What keep_results of rank 0 waits for.
void collect_results(Simulation& simulation, const Surfaces& surfaces, bool failed) {
  const OutputSettings& output = simulation.scene().output;
  if (failed && simulation.scene().has_frames()) collect_frame(simulation, surfaces);
  find_crushed_out(simulation);
  gather_for_pictures(simulation);
  if (output.plots && !shows_blocks(simulation)) collect_cracks(simulation, surfaces);
  if (output.end_state && !failed) simulation.save({});
}

Scene scene_of(RunOptions* options, const Ranks* ranks) {
  if (ranks) options->scene.processes = ranks->count(), options->scene.processes_here = ranks->count_on_this_machine();
  options->scene.runs = true;
  Scene scene = prepare_scene(options->scene);
  if (options->report && pieces_of(scene, ranks).count > 1)
    throw Error(Exit::usage, "--report: not with output.pieces, which ParaView reads and the page does not");
  if (options->report && !scene.has_frames())
    throw Error(Exit::usage,
                "--report: the page shows frames, and with output.frames = 0 there are none; set output.frames, for "
                "instance with --set output.frames=20, or leave --report out");
  if (options->serve >= 0 && (!scene.has_frames() || scene.output.pieces))
    throw Error(Exit::usage,
                "--live, --serve: the page shows frames, each in one file: leave output.pieces out, and set "
                "output.frames, for instance with --set output.frames=20");
  if ((options->report || options->serve >= 0) && (!ranks || ranks->rank() == 0)) require_report_library();
  return scene;
}

// Where the run in this folder was kept, or where its scene starts.
void begin(Simulation* simulation, const fs::path& folder, const StoredState& kept) {
  if (kept.bytes > 0)
    restore_from(folder / "checkpoint.bin", kept, simulation);
  else
    take_start(simulation);
}

void follow(RunOptions options, Ranks& ranks, int& exit_code) {
  if (!options.resume.empty()) {
    options.resume = fs::absolute(options.resume).string();  // read_run_record goes to where the run was started
    if (is_done(options.resume)) return;
    options.scene = read_run_record(options.resume);
  }
  if (!options.again.empty()) options.scene = options_of(read_provenance(options.again));
  Simulation simulation(scene_of(&options, &ranks), threads_of(options, &ranks), &ranks);
  StoredState state;
  ranks.share(std::as_writable_bytes(std::span(&state, 1)));
  if (state.is_refused) throw Error(Exit::bad_input, "the checkpoint is refused by rank 0, which says why");
  begin(&simulation, options.resume, state);
  const Pieces pieces = pieces_of(simulation.scene(), &ranks);
  SharedFolder folder;
  if (pieces.count > 1) {
    share(ranks, folder);
    use_part_token(folder.token);
  }
  const LawWatchdog watchdog(options.law_seconds, [&](const Material& material, const quoin_batch& batch) {
    notices_wanted = true;
    notice(fmt::format("quoin: rank {}: the law '{}' has not returned from a batch within {:g} s: {}", ranks.rank(),
                       material.api().id, options.law_seconds, simulation.batch_text(batch)));
    _exit(static_cast<int>(Exit::numerical));
  });
  const StopOnSignal guard(simulation);
  Follower follower(folder, options.compressed, pieces);
  const auto print_fault = [&](const std::string& text) {
    notices_wanted = true;
    notice(fmt::format("quoin: rank {}: {}", ranks.rank(), text));
  };
  bool failed = false;
  try {
    simulation.run(follower);
  } catch (const Error& error) {
    failed = true;
    exit_code = static_cast<int>(error.exit_code);
    if (!simulation.ranks_together()) {
      print_fault(error.what());
      ranks.abort(exit_code);
    }
  }
  collect_results(simulation, follower.surfaces(), failed);
  if (failed || !follower.fault()) return;
  exit_code = static_cast<int>(follower.fault()->exit_code);
  print_fault(fmt::format("frames for ParaView lack its pieces: {}", follower.fault()->what()));
}

// Before the first step. resumed: by --resume, goes_on: from a checkpoint.
void say_what_begins(const RunOptions& options, const Simulation& simulation, const Ranks* ranks, int wanted_threads,
                     bool resumed, bool goes_on, Recorder& recorder) {
  const auto say = [&](const std::string& text) { recorder.progress().message(text); };
  const TimeStepReport& step = simulation.time_step_report();
  say(fmt::format(
      "{}: {} blocks and beams, {} zones, {} contact points; law {}; time step {:.3g} s ({:.2f} of 2/omega_max); {}{} "
      "threads, {}",
      options.scene.scene, simulation.block_count(), simulation.zone_count(), simulation.point_count(),
      law_names(simulation.assembly()), step.time_step, step.time_step / step.critical.value,
      ranks ? fmt::format("{} ranks of ", ranks->count()) : "", simulation.thread_count(),
      simulation.instruction_set()));

  const OutputSettings& output = simulation.scene().output;
  const bool has_frames = simulation.scene().has_frames();
  if (options.compressed && !has_frames)
    say("--compressed: without effect, as output.frames = 0 writes no files for ParaView");
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

// curve.png, cracks.png, mechanism.png, histories.png; what is missing is reported.
void draw(const fs::path& folder, const Simulation& simulation, const Surfaces& surfaces, const RunInfo& info,
          const RunOptions& options, Recorder& recorder) {
  const auto& rows = recorder.history().rows();
  const std::string label = warning_label(info.warnings), law = law_names(simulation.assembly());
  // Each waits for a gnuplot of its own.
  auto curve = std::async(std::launch::async | std::launch::deferred, [&] {
    return notice_of([&] { return plot_curve(folder, rows, simulation.scene(), law, label); });
  });
  std::string of_cracks, of_mechanism, of_histories;
  if (options.histories)
    of_histories = notice_of([&] { return plot_histories(folder, rows, simulation.scene(), label); });
  if (!info.law_answers) {
    of_cracks = "no cracks.png: the law no longer tells the states of contact points";
  } else if (shows_blocks(simulation)) {
    of_mechanism = notice_of([&] { return plot_mechanism(folder, simulation, rows, label); });
    of_cracks = notice_of([&] { return plot_block_cracks(folder, simulation, surfaces, rows, label); });
  } else {
    of_cracks = notice_of([&] { return plot_cracks(folder, simulation, surfaces, rows, law, label); });
  }
  for (const std::string& notice : {curve.get(), of_cracks, of_mechanism, of_histories}) {
    if (!notice.empty()) recorder.progress().message("quoin: " + notice);
  }
  for (const char* name : {"curve", "cracks", "mechanism", "histories"}) {
    if (!options.svg || !fs::exists(folder / (std::string(name) + ".png"))) continue;
    const std::string notice = notice_of([&] { return draw_as_svg(folder, name); });
    if (!notice.empty()) recorder.progress().message("quoin: " + notice);
  }
}

// What was computed is kept, whatever ended the run; the summary says what ended it. What cannot be written is
// reported, and costs nothing else but the exit code.
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
  const bool has_all = !failure || simulation.ranks_together();  // else of this rank alone
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
  if (output.plots && has_all) draw(folder, simulation, surfaces, info, options, recorder);
  keep([&] { note_results(simulation, folder, &info.provenance); });
  info.wall_clock_s = process_seconds();
  keep([&] { write_summary(folder / "summary.json", simulation, rows, info); });
  keep([&] {
    if (options.report) write_report({folder});
  });
  keep([&] {
    if (output.end_state && !failure) write_end_state(folder, simulation, info.provenance);
  });
  std::error_code ignored;
  if (!failure && exit_code == 0) fs::remove(folder / "checkpoint.bin", ignored);  // of no use any more
}

// The peak is that of the monitor, whose displacement has the ground's in it: of an earthquake this counts.
void print_response(const std::vector<HistoryRow>& rows, const Scene& scene) {
  const HistoryRow *farthest = nullptr, *sheared = nullptr;
  std::size_t along = 0;
  double most = 0.0, shear = 0.0;
  for (const HistoryRow& row : rows) {
    const Stage& stage = scene.stages[static_cast<std::size_t>(row.stage)];
    if (!stage.ground) continue;
    along = axis_of(stage) == 2 ? 2 : 0;
    const double moved = std::abs(row.monitor_relative[along]), base = std::abs(row.base_force[along]);
    if (moved > most) most = moved, farthest = &row;
    if (base > shear) shear = base, sheared = &row;
  }
  if (farthest == nullptr || sheared == nullptr) return;
  fmt::print(
      "earthquake: {} moves {:.3f} mm along {} against the ground (at {:.3f} s), base shear {:.2f} kN (at {:.3f} s)\n",
      moved_part(scene, scene.stages.back()), most * 1e3, "xyz"[along], farthest -> time, shear / 1e3, sheared -> time);
}

void print_results(const fs::path& folder, const Simulation& simulation, const std::vector<HistoryRow>& rows,
                   const RunInfo& info) {
  if (const auto& multiplier = simulation.outcome().collapse_multiplier) {
    const auto lag = collapse_lag(simulation.scene(), multiplier);
    fmt::print("collapse multiplier {:.4f}{}\n", *multiplier,
               lag ? fmt::format("; the blocks have stood under {:.4f}, {:.1f} % less", *multiplier - *lag,
                                 100.0 * *lag / *multiplier)
                   : "");
  }
  const Scene& scene = simulation.scene();
  const Peak peak = find_peak(rows, scene);
  const std::string unknown = why_error_unknown(scene, info);
  const std::string error = unknown.empty() ? fmt::format("expected error at quality {}: {:.1f} %", scene.quality,
                                                          100 * quality_named(scene.quality).peak_error)
                                            : "error not known: " + unknown;
  fmt::print("peak {:.2f} kN at {:.3f} mm{} ({}); {} steps in {:.1f} s; results in {}\n", peak.force / 1e3,
             peak.displacement * 1e3, is_vertical(scene) ? " upright" : "", error, simulation.step(), info.wall_clock_s,
             folder.string());
  const bool shaken =
      std::any_of(scene.stages.begin(), scene.stages.end(), [](const Stage& s) { return s.ground.has_value(); });
  if (shaken) print_response(rows, scene);
  if (shaken && !rows.empty() && rows.back().energies) {
    const Energies& e = *rows.back().energies;
    const double joints = e.dissipated[0] + e.dissipated[1] + e.dissipated[2] + e.dissipated[3];
    const double all = e.damping + e.members_dissipated + joints;
    const auto share = [&](double part) { return 100.0 * part / all; };
    if (e.members_dissipated > 0.0) {
      fmt::print("dissipated {:.4g} J: damping {:.0f} %, members {:.0f} %, joints {:.0f} %\n", all, share(e.damping),
                 share(e.members_dissipated), share(joints));
    } else if (all > 0.0) {
      fmt::print("dissipated {:.4g} J: damping {:.0f} %, joints {:.0f} %\n", all, share(e.damping), share(joints));
    }
  }
  fmt::print("{}\n", phases_text(simulation.phase_times(), info.wall_clock_s));
  if (!simulation.rank_traffic().empty()) fmt::print("{}\n", ranks_text(simulation.rank_traffic()));
  print_isolation(simulation);
}

// Before the work, as far as it can be known: a full disk is found out about too late otherwise.
void require_room(const fs::path& folder, const Simulation& simulation, const Surfaces& surfaces) {
  const Scene& scene = simulation.scene();
  double frames = 2.0;
  for (std::size_t i = 0; i < scene.stages.size(); ++i) frames += scene.frames_in(i);
  require_space(folder, 1e6 + frames * (scene.has_frames() ? frame_bytes(simulation, surfaces) : 0.0),
                fmt::format("the results with output.frames = {}", scene.output.frames));
}

void run(RunOptions options, Ranks* ranks, int& exit_code) {
  fs::path folder =
      options.out.empty() ? fs::path("out") / fs::path(options.scene.scene).stem() : fs::path(options.out);
  std::shared_ptr<FolderLock> lock;
  if (!options.resume.empty()) {
    folder = fs::absolute(options.resume);
    lock = take_folder(folder, &options.scene);
    if (!lock) {
      fmt::print("{}: the run is done; nothing to resume\n", options.resume);
      return;
    }
  }
  std::optional<Provenance> there;  // of the run that is repeated
  if (!options.again.empty()) {
    there = read_provenance(options.again);
    options.again = fs::absolute(options.again);
    folder = fs::absolute(options.out.empty() ? folder_again(options.again) : folder);
    const bool force = options.scene.force;
    options.scene = options_of(*there);
    options.scene.force = force;
  }
  if (options.law_seconds != kLawSeconds) law_loading_seconds = options.law_seconds;
  Scene scene = scene_of(&options, ranks);
  keep_start(scene, folder);
  const int wanted = threads_of(options, ranks);
  if (options.isolate_law) isolate_laws({wanted, options.law_seconds});
  Simulation simulation(std::move(scene), wanted, ranks);
  RunInfo info;
  info.provenance = provenance_of(simulation, {options.scene.law, options.scene.overrides});
  if (there) hold_against(info.provenance, *there);
  Identity identity = identity_of(simulation, info.provenance);
  Checkpoint before;
  const bool goes_on = lock && fs::exists(folder / "checkpoint.bin");
  std::optional<Error> refused;
  try {
    if (goes_on) before = find_checkpoint(folder / "checkpoint.bin", identity);
  } catch (const Error& error) {
    refused = error;
    before.stored.is_refused = true;
  }
  if (ranks) ranks->share(std::as_writable_bytes(std::span(&before.stored, 1)));
  if (refused) throw *refused;
  begin(&simulation, folder, before.stored);
  const Pieces pieces = pieces_of(simulation.scene(), ranks);
  if (pieces.count > 1) {
    SharedFolder shared{fs::absolute(folder).string(), part_token(), before.frame_times};
    share(*ranks, shared);
  }
  std::vector<Monitor> monitors =
      monitors_of(simulation.scene().text, simulation.scene().file, options.scene.overrides);
  const auto of_monitors = goes_on && !before.rows.empty() ? read_monitor_rows(folder, before.rows.back().step)
                                                           : std::vector<std::vector<double>>{};
  // What an earlier run left goes, so that a failed run cannot be taken for that one.
  const ResultFolder own(folder, lock, [&](const std::string& name) {
    return lock != nullptr && is_kept(name, before.frame_times.size());
  });
  if (!lock) write_run_record(folder, options.scene, simulation.scene().text);

  Surfaces surfaces;
  require_room(folder, simulation, surfaces);
  Recorder recorder(folder, simulation, surfaces, std::move(identity), options.checkpoint_every, before,
                    options.compressed, pieces);
  if (!monitors.empty() && ranks)
    recorder.progress().message("quoin: no monitors.csv, as no rank has all blocks; run it in one process for that");
  else if (!monitors.empty())
    recorder.follow(folder, simulation, std::move(monitors), of_monitors);
  say_what_begins(options, simulation, ranks, wanted, lock != nullptr, goes_on, recorder);
  if (options.serve >= 0) recorder.serve(options.serve, folder, simulation);

  std::optional<Error> failure;
  const LawWatchdog watchdog(options.law_seconds, [&](const Material& material, const quoin_batch& batch) {
    end_with_law(material, batch, options.law_seconds, folder, simulation, recorder, info);
  });
  const StopOnSignal guard(simulation);  // to the end: what stops a run shall not stop what keeps its results
  try {
    simulation.run(recorder);
  } catch (const std::exception& error) {  // by a law, perhaps
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
  if (there && info.status != "interrupted" && !say_whether_same(info.provenance, folder, *there, options.again) &&
      exit_code == 0)
    exit_code = static_cast<int>(Exit::numerical);
  if (failure && !simulation.ranks_together()) {
    std::fflush(stdout);
    ranks->abort(exit_code);
  }
}

// Where mpirun has started several of us: rank 0 runs as one process does, the others help. What stops one rank ends
// all: those that fail together are spoken for by rank 0, and one that fails alone says so.
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
    notice(fmt::format("quoin: {}", error.what()));  // of rank 0
    if (!ranks->all_here(kTogether)) end_alone(error.exit_code, error.what());
  } catch (const std::exception& error) {
    const Error reported = any_error(error, "fewer ranks on each machine, or a smaller scene");
    end_alone(reported.exit_code, reported.what());
  }
}

}  // namespace

void add_rest_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("rest", "The state at rest under weight and constant loads");
  auto options = std::make_shared<RunOptions>();
  auto stage = std::make_shared<std::string>();
  command->add_option("scene", options->scene.scene, "Scene file")->type_name("SCENE.toml")->required();
  command->add_option("--out", options->out, "Folder for the results (default: out/<name of the scene>_rest)")
      ->type_name("DIR");
  command
      ->add_option("--stage", *stage,
                   "Whose weight, forces, pressures and supports; else the first that has a weight or a load")
      ->type_name("NAME");
  command->add_option("--threads", options->threads, "Threads (default: all of the machine)")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  command->add_option("--law", options->scene.law, "Law for all joints in place of the scene's");
  command->add_option("--set", options->scene.overrides, "dotted.key=value: set a key of the scene; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--report", options->report, "Write report.html too, a page of the state");
  command->add_flag("--force", options->scene.force, "Go on where the model seems too large for this machine");
  command->footer(
      "A stage of kind rest in place of all of the scene's: equilibrium is found by Newton's method and settled by "
      "steps.\n"
      "What the stage moves, shakes or lets grow is left out. Results are those of a run; end_state.bin is where\n"
      "scenes with start = \"DIR\" begin, whose first stage is that one, and quoin modes --state DIR.\n"
      "Examples:\n"
      "  quoin rest host/scenes/arch.toml --out out/arch_rest\n"
      "  quoin modes host/scenes/arch.toml --state weight");
  command->callback([options, stage, &exit_code] {
    if (options->out.empty()) options->out = "out/" + fs::path(options->scene.scene).stem().string() + "_rest";
    options->scene.overrides.push_back(std::string(kRestAsked) + *stage);
    run_on_ranks(*options, exit_code);
  });
}

void add_run_command(CLI::App& app, int& exit_code) {
  process_seconds();  // starts the clock
  CLI::App* command = app.add_subcommand("run", "Run a scene and write its results");
  auto options = std::make_shared<RunOptions>();
  CLI::Option* scene =
      command->add_option("scene", options->scene.scene, "Scene file; host/scenes/README.md lists its keys")
          ->type_name("SCENE.toml");
  CLI::Option* out =
      command->add_option("--out", options->out, "Folder for the results (default: out/<name of the scene>)")
          ->type_name("DIR");
  command->add_option("--threads", options->threads, "Threads (default: all of the machine)")
      ->type_name("N")
      ->check(CLI::Range(1, 4096));
  CLI::Option* law =
      command
          ->add_option("--law", options->scene.law, "Law for all joints in place of the scene's: a name or a library")
          ->type_name("NAME_OR_PATH");
  CLI::Option* set = command->add_option("--set", options->scene.overrides, "Set a key of the scene; may be repeated")
                         ->type_name("dotted.key=value")
                         ->allow_extra_args(false);
  command->add_flag("--report", options->report, "Write report.html too, a page of the run (quoin report --help)");
  command->add_flag("--histories", options->histories,
                    "Write histories.png: displacements, forces and energies over time");
  command->add_flag("--svg", options->svg, "Write each picture as SVG too, beside its PNG");
  command->add_flag(
      "--live", [options](std::int64_t) { options->serve = 0; },
      "Show the run in a browser while it goes on, at an address of this machine that is printed");
  command->add_option("--serve", options->serve, "The same at this port; 0: any that is free")
      ->type_name("PORT")
      ->check(CLI::Range(0, 65535));
  command->add_flag("--compressed", options->compressed, "Compress the files for ParaView");
  command->add_flag("--force", options->scene.force, "Go on where the model seems too large for this machine");
  command->add_flag("--isolate-law", options->isolate_law,
                    "Evaluate each law in a process of its own: its crash costs the law and keeps the results; slower");
  command
      ->add_option(
          "--law-seconds", options->law_seconds,
          "Seconds that a law has for one batch, or to be loaded, before the run ends and names it; 0: any time "
          "(default: 60, and 10 to be loaded)")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e9));
  command
      ->add_option("--checkpoint-every", options->checkpoint_every,
                   "Seconds between two checkpoints, from which --resume goes on; 0: none (default: 60)")
      ->type_name("SECONDS")
      ->check(CLI::Range(0.0, 1e9));
  CLI::Option* resume =
      command
          ->add_option("--resume", options->resume,
                       "Go on with the run in this folder, which was stopped or killed, from its last checkpoint")
          ->type_name("DIR")
          ->excludes(scene, out, law, set);
  command
      ->add_option(
          "--again", options->again,
          "Repeat the run in this folder, as its summary.json has it, and say whether the bits agree (results to "
          "DIR-again)")
      ->type_name("DIR")
      ->excludes(scene, law, set, resume);
  command->footer(
      "Results: history.csv, summary.json, curve.png, cracks.png, blocks.pvd, joints.pvd and forces.pvd (for "
      "ParaView).\n"
      "Examples:\n"
      "  quoin run host/scenes/solid_wall_030.toml\n"
      "  quoin run host/scenes/solid_wall_030.toml --live        in a browser while it goes on\n"
      "  quoin run host/scenes/solid_wall_030.toml --out /tmp/brittle --law coulomb_slip\n"
      "  quoin run host/scenes/solid_wall_030.toml --law ./my_law.so --threads 2\n"
      "  quoin run host/scenes/solid_wall_030.toml --set solver.quality=fast       or reference: slower, smaller "
      "error\n"
      "  quoin run host/scenes/wall_2m_576.toml --out /tmp/long --checkpoint-every 300\n"
      "  quoin run --resume /tmp/long      after a crash, kill or Ctrl-C: the results are those of one run\n"
      "  quoin run --again /tmp/long       the same run once more: are the bits the same?\n"
      "  quoin run host/scenes/solid_wall_121.toml --set stage.shear.velocity=0.01 --set "
      "joints.mortar.cohesion=0.35e6");
  command->callback([options, scene, &exit_code] {
    if (options->resume.empty() && options->again.empty() && scene->count() == 0)
      throw CLI::RequiredError("SCENE.toml, --resume DIR or --again DIR");
    run_on_ranks(*options, exit_code);
  });
}

}  // namespace quoin
