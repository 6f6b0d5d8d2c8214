#include "cli/recorder.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <utility>

#ifdef QUOIN_MODES
#include "analysis/damping_ratios.h"
#endif
#include "results/plots.h"
#include "scene/damping_text.h"
#include "step/large_motion.h"
#include "step/results.h"

namespace quoin {

namespace fs = std::filesystem;

Recorder::Recorder(const fs::path& folder, const Simulation& simulation, Surfaces& surfaces, Identity identity,
                   double checkpoint_every, const ResultsSoFar& before, bool compressed, Pieces pieces)
    : scene_(simulation.scene()),
      surfaces_(surfaces),
      history_(folder / "history.csv", simulation, before.rows),
      frames_(folder, surfaces, before.frame_times, compressed, pieces),
      checkpoint_(folder / "checkpoint.bin"),
      identity_(std::move(identity)),
      clock_(checkpoint_every),
      modes_(before.modes) {
  for (const HistoryRow& row : before.rows) take(row);
}

void Recorder::on_stage_begin(const Simulation& simulation, int stage) {
  const Stage& s = scene_.stages[static_cast<size_t>(stage)];
  std::string text = fmt::format("stage {}/{} {}: until {}", stage + 1, scene_.stages.size(), s.name, end_of(s));
  if (s.ground) text += "; ground motion, " + ground_text(*s.ground, s.duration);
  const TimeStepReport& step = simulation.time_step_report();
  if (const std::string own = own_solver_text(scene_, static_cast<size_t>(stage)); !own.empty())
    text += fmt::format("; {}: time step {:.3g} s ({:.2f} of 2/omega_max)", own, step.time_step,
                        step.time_step / step.critical.value);
  const std::optional<ImpactTerms> impacts = damping_of(scene_.solver_in(static_cast<size_t>(stage))).impacts;
  const double in_use = step.impacts.in_use;
  if (impacts && in_use > 0.0 && in_use < 0.99 * impacts->share)
    text += fmt::format(", at which {:.2g} of the impact damping of {:g} is in use", in_use, impacts->share);
  if (in_use > 0.0)
    text += fmt::format("; an edge that lands comes back with {:.2g} of its velocity", landing_restitution(in_use));
  progress_.message(text);
#ifdef QUOIN_MODES
  if (!s.ground) return;
  const bool goes_on = !modes_.empty() && modes_.back().stage == stage;
  if (!goes_on) modes_.push_back(damped_modes(simulation, stage));
  progress_.message(modes_text(modes_.back()));
#endif
}

void Recorder::on_law_swap(const LawSwap& swap) {
  progress_.message(
      fmt::format("joint family '{}': law {} replaced by {} at {} contact points, tractions kept; stored "
                  "energy {:.6g} J, jump {:+.3g} J{}",
                  swap.family, swap.from, swap.to, swap.points, swap.stored_before, swap.energy_jump,
                  swap.limited ? fmt::format("; {} points lose damage", swap.limited) : ""));
}

void Recorder::on_warning(const Warning& warning) {
  reported_.insert(warning.about);
  progress_.message("quoin: warning: " + warning.text);
}

void Recorder::on_promotion(const Simulation& simulation) {
  const Promotion& p = *simulation.outcome().promotion;
  progress_.message(
      fmt::format("{}. On in large motion from step {}, {:.6g} s: {} contact points with their tractions and states, "
                  "strain energy {:.6g} J, jump {:+.3g} J; time step {:.3g} s",
                  p.why, p.step, p.time, simulation.point_count(), p.strain_energy, p.energy_jump,
                  simulation.time_step_report().time_step));
  surfaces_ = Surfaces();
}

void Recorder::on_row(const HistoryRow& row) {
  history_.add(row);
  if (monitors_) monitors_->add(row);
  take(row);
  if (live_) live_->add_row(row);
}

void Recorder::serve(std::unique_ptr<PageServer> server, const fs::path& folder, const Simulation& simulation) {
  simulation_ = &simulation;
  live_ = std::make_unique<LiveRun>(std::move(server), folder, simulation, history_.rows(), frames_.times());
  progress_.message("the run goes on at " + live_->address());
}

void Recorder::follow(const fs::path& folder, const Simulation& simulation,
                      const std::vector<std::vector<double>>& before) {
  monitors_.emplace(folder, simulation, before);
}

void Recorder::finish_tables() {
  history_.finish();
  if (monitors_) monitors_->finish();
}

void Recorder::on_pause(const Simulation& simulation, bool) {
  try {
    ResultsSoFar results{history_.rows(), frames_.times(), modes_};
    if (monitors_) results.monitor_rows = monitors_->rows();
    write_checkpoint(checkpoint_, identity_, results, simulation);
  } catch (const Error& error) {  // the run continues, and earlier results remain
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

void Recorder::on_progress(const Progress& progress) {
  if (live_) {
    so_far_.cracked = cracked_share(*simulation_);
    live_->show(progress, so_far_);
  }
  progress_.show(progress, so_far_);
}

void Recorder::on_frame(const Simulation& simulation, int, int) {
  if (frames_fault_) return frames_.leave_out(simulation);
  try {
    frames_.add_piece(simulation);
    if (live_) live_->add_frame(simulation, history_.rows());
  } catch (const Error& error) {  // the run continues without frames
    frames_fault_ = error;
    progress_.message(fmt::format("quoin: warning: no more frames for ParaView: {}", error.what()));
  }
}

void Recorder::on_stage_end(const Simulation& simulation, int stage, const HistoryRow& last) {
  const Stage& done = scene_.stages[static_cast<size_t>(stage)];
  const Response r = response(last, done);
  const std::string measured =
      watches_nothing(scene_, done)
          ? ""
          : fmt::format("{:.3f} mm{}, horizontal {:.2f} kN, vertical {:.2f} kN, ",
                        shown(last, scene_).displacement * 1e3, is_vertical(scene_) ? " upright" : "",
                        r.horizontal_force / 1e3, r.vertical_force / 1e3);
  progress_.message(fmt::format("stage {}/{} done after {} steps: {}unbalanced ratio {:.1e}", stage + 1,
                                scene_.stages.size(), simulation.step(), measured, last.unbalanced_ratio));
  for (const StopAtForceLoss& stop : simulation.outcome().force_losses) {
    if (stop.stage == stage)
      progress_.message(
          fmt::format("stopped at force loss: half cycle {} reached {:.2f} kN, {:.2f} of {:.2f} kN before",
                      stop.half_cycle + 1, stop.force / 1e3, stop.force / stop.largest, stop.largest / 1e3));
  }
}

void Recorder::take(const HistoryRow& row) {
  const Shown now = shown(row, scene_);
  const auto stage = static_cast<std::size_t>(row.stage);
  if (!same_curve(scene_, scene_.stages[stage], scene_.stages[stage_of_peak_])) so_far_.peak = 0.0;
  stage_of_peak_ = stage;
  so_far_.displacement = now.displacement, so_far_.force = now.force;
  so_far_.kinetic_energy = row.kinetic_energy;
  if (std::abs(now.force) > std::abs(so_far_.peak))
    so_far_.peak = now.force, so_far_.displacement_at_peak = now.displacement;
}

double Recorder::cracked_share(const Simulation& simulation) {
  const auto counts = condition_counts(simulation);
  const long all = std::accumulate(counts.begin(), counts.end(), 0L);
  const long elastic = counts[static_cast<std::size_t>(Condition::elastic)];
  return all > 0 ? static_cast<double>(all - elastic) / static_cast<double>(all) : 0.0;
}

}  // namespace quoin
