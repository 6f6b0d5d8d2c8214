#include "step/stage_run.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "step/actions/actions.h"
#include "step/actions/ground.h"
#include "step/damage_growth.h"
#include "step/gather.h"
#include "step/large_motion_run.h"
#include "step/measure.h"
#include "step/rank_agreement.h"
#include "step/rank_load.h"
#include "step/rest.h"
#include "step/run_watch.h"
#include "step/small_motion.h"
#include "step/stages.h"
#include "step/step.h"
#include "step/supports.h"

namespace quoin {

namespace {

constexpr long kCollapseInterval = 10;    // steps between two checks of how far blocks have moved
constexpr long kPauseInterval = 16;       // steps between two possible checkpoints
constexpr long kClockInterval = 64;       // steps between two checks of the clock
constexpr double kProgressPeriod = 0.25;  // s

}  // namespace

StageRun::StageRun(Simulation& simulation, Simulation::Impl& impl, Observer& observer, int stage)
    : simulation_(simulation),
      s_(impl),
      observer_(observer),
      index_(stage),
      settings_(impl.scene.stages[static_cast<std::size_t>(stage)]),
      frames_(impl.scene.frames_in(static_cast<std::size_t>(stage))),
      frames_follow_damage_(impl.scene.frames_follow_damage_in(static_cast<std::size_t>(stage))) {
  begin(impl.progress.in_stage);
  reported_at_ = Clock::now();
  reported_steps_ = s_.progress.stage_step;
  reported_fraction_ = stage_fraction(s_);
}

// Observers follow a promotion also where what comes after it throws: results are then those of large motion.
template <class Act>
void StageRun::report_promotion(const Act& act) {
  const bool on_lattice = !s_.large_motion;
  const auto report = [&] {
    if (on_lattice && s_.large_motion && s_.outcome.promotion) observer_.on_promotion(simulation_);
  };
  try {
    act();
  } catch (...) {
    report();
    throw;
  }
  report();
}

void StageRun::begin(bool was_in_stage) {
  report_promotion([&] {
    if (!was_in_stage) begin_stage(s_, index_), note_crushed(s_);
    if (!was_in_stage && settings_.kind == "rest") find_rest(s_, [&] { return simulation_.stop_requested(); });
  });
  observer_.on_stage_begin(simulation_, index_);
  if (!was_in_stage) {
    warn_of_loose_blocks(s_, &warnings_), warn_of_unused_bounds(s_, &warnings_);
    warn_of_no_monitor(s_, &warnings_), warn();
  }
  for (const LawSwap& swap : s_.laws.swaps) observer_.on_law_swap(swap);
}

bool StageRun::advance() {
  const Due due = look_ahead();
  const bool done = has_ended(due);
  if (done) step_once(s_, true, true);  // all measurements, for the last row and the results after it
  gone_over_ = false, frame_due_ = due.frame;
  // Pauses before a row that only the stop requests: the history of a resumed run has none there.
  const bool stop_between_rows = due.stop && !due.planned && !done;
  if (stop_between_rows) follow_motion(done), show_frame(), pause(true);
  if (frames_follow_damage_ && (due.planned || done))
    write([&] { damage_due_ = damage_has_grown(s_, done, &warnings_); });
  if ((due.row && !gone_over_) || done) write_row(done);
  if (!stop_between_rows) follow_motion(done);
  if (due.check || due.row || done) find_falling_block(s_, &warnings_), warn();
  if (!done) show_frame();  // else end() shows it
  if (due.stop && due.planned && !done) pause(true);
  if (due.stop)
    throw Error(Exit::interrupted,
                fmt::format("stopped at step {} of stage '{}'", s_.progress.stage_step, settings_.name));
  if (!done) {
    require_steps_left();
    if (s_.progress.stage_step % kPauseInterval == 0) pause(false);
    balance_ranks(s_);
  }
  report_progress();
  return done;
}

StageRun::Due StageRun::look_ahead() {
  s_.agreed.stop_wanted = simulation_.stop_requested();
  Due due;
  due.stop = s_.ranks ? s_.agreed.stop : s_.agreed.stop_wanted;
  due.check = settings_.equilibrium_ratio && s_.progress.stage_step % kCheckInterval == 0;
  due.planned = s_.progress.stage_step >= s_.progress.next_row;
  due.row = due.stop || due.planned;
  due.frame =
      frames_ > 0 && s_.progress.next_frame <= frames_ && stage_fraction(s_) * frames_ >= s_.progress.next_frame;
  s_.energy.sampled = s_.watch.pending || (due.planned && begins_check(s_));
  const bool count_crushed = due.row && s_.progress.step >= s_.watch.next_flags;
  if (count_crushed) s_.watch.next_flags = Watch::after(s_.progress.step);
  step_once(s_, due.check || due.row || due.frame || books_energy(s_) || s_.energy.sampled, count_crushed || due.frame);
  return due;
}

// Each criterion is evaluated: its findings are kept, whichever of them ends the stage.
bool StageRun::has_ended(const Due& due) {
  bool ended = due.check && equilibrium_reached(s_, settings_);
  ended |= force_lost(s_);
  ended |= push_lost(s_, &warnings_);
  ended |= stage_fraction(s_) >= 1.0;
  if (s_.large_motion && s_.progress.stage_step % kCollapseInterval == 0) ended |= collapse_ended(s_, &warnings_);
  return ended;
}

void StageRun::follow_motion(bool done) {
  report_promotion([&] { gone_over_ = quoin::follow_motion(s_, done, &warnings_); });
  warn();
}

void StageRun::show_frame() {
  if (!frame_due_ && !damage_due_) return;
  fetch_for_frame(s_);
  const int frame = s_.progress.next_frame;
  if (frame_due_) ++s_.progress.next_frame;
  write([&] { observer_.on_frame(simulation_, index_, frame); });
  frame_due_ = damage_due_ = false;
}

void StageRun::write_row(bool done) {
  gather(s_, Part::row);
  const auto before = Clock::now();
  const HistoryRow row = measure_row(s_);
  s_.timing.phases[Phase::measurement] += seconds_since(before);
  require_finite(s_, row);
  write([&] { observer_.on_row(row); });
  const auto watched = Clock::now();
  if (s_.large_motion) check_rotations(s_);
  // Checked at the end of each stage.
  if (done) s_.watch.next_stiffness = std::min(s_.watch.next_stiffness, s_.progress.step);
  const std::vector<Warning> of_watch = new_warnings(s_, done);
  warnings_.insert(warnings_.end(), of_watch.begin(), of_watch.end());
  s_.timing.phases[Phase::watch] += seconds_since(watched);
  warn();
  if (s_.progress.next_row < s_.progress.stage_step)
    s_.progress.next_row += (s_.progress.stage_step - s_.progress.next_row + s_.progress.row_interval - 1) /
                            s_.progress.row_interval * s_.progress.row_interval;
}

void StageRun::pause(bool last) {
  if (!any_rank(s_, observer_.wants_pause(last))) return;
  if (!s_.parts.divided) gather(s_, Part::all);
  if (s_.large_motion) copy_velocities(*s_.large_motion);
  std::optional<Error> fault;  // fault of one rank, at which all end together
  try {
    write([&] { observer_.on_pause(simulation_, last); });
  } catch (const Error& error) {
    fault = error;
  }
  if (any_rank(s_, fault.has_value()))
    throw fault ? *fault : Error(Exit::bad_input, "another rank could not keep what was computed");
}

void StageRun::require_steps_left() const {
  if (s_.progress.stage_step < settings_.max_steps) return;
  std::string reason = fmt::format("stage '{}' has not ended after {} steps", settings_.name, s_.progress.stage_step);
  if (settings_.equilibrium_ratio) {
    reason += fmt::format(": unbalanced force ratio {:.4g}, wanted {:.4g}", s_.progress.unbalanced_ratio,
                          *settings_.equilibrium_ratio);
  }
  throw Error(Exit::numerical, reason + ". Raise max_steps, or find out what keeps moving");
}

void StageRun::report_progress() {
  if (s_.progress.stage_step % kClockInterval != 0 || seconds_since(reported_at_) < kProgressPeriod) return;
  const double seconds = seconds_since(reported_at_), by_length = stage_fraction(s_);
  Progress progress;
  progress.stage = index_;
  progress.stage_count = static_cast<int>(s_.scene.stages.size());
  progress.settings = &settings_;
  progress.step = s_.progress.stage_step;
  progress.unbalanced_ratio = s_.progress.unbalanced_ratio;
  progress.fraction = by_length;
  if (settings_.equilibrium_ratio && s_.progress.unbalanced_ratio > 0.0 &&
      std::isfinite(s_.progress.unbalanced_ratio) && *settings_.equilibrium_ratio < 1.0) {
    progress.fraction =
        std::max(by_length, std::log(s_.progress.unbalanced_ratio) / std::log(*settings_.equilibrium_ratio));
  }
  progress.fraction = std::clamp(progress.fraction, 0.0, 1.0);
  progress.steps_per_second = static_cast<double>(s_.progress.stage_step - reported_steps_) / seconds;
  progress.seconds_left =
      by_length > reported_fraction_ ? seconds * (1.0 - by_length) / (by_length - reported_fraction_) : -1.0;
  observer_.on_progress(progress);
  reported_at_ = Clock::now();
  reported_steps_ = s_.progress.stage_step;
  reported_fraction_ = by_length;
}

void StageRun::end() {
  if (!s_.parts.divided) gather(s_, Part::all);
  // The last frame shows the end, in place of frames that are still due.
  frame_due_ |= frames_ > 0 && s_.progress.next_frame <= frames_;
  show_frame();
  gather(s_, Part::row);
  s_.progress.in_stage = false;
  observer_.on_stage_end(simulation_, index_, measure_row(s_));
}

void StageRun::warn() {
  for (const Warning& warning : warnings_) observer_.on_warning(warning);
  warnings_.clear();
}

}  // namespace quoin
