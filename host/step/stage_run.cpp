#include "step/stage_run.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "step/rest.h"

namespace quoin {

namespace {

constexpr long kCollapseInterval = 10;    // steps between two looks at how far blocks have moved
constexpr long kPauseInterval = 16;       // steps between two moments at which a checkpoint may be taken
constexpr long kClockInterval = 64;       // steps between two looks at the clock
constexpr double kProgressPeriod = 0.25;  // s

}  // namespace

StageRun::StageRun(Simulation& simulation, Simulation::Impl& impl, Observer& observer, int stage)
    : simulation_(simulation),
      s_(impl),
      observer_(observer),
      index_(stage),
      settings_(impl.scene.stages[static_cast<std::size_t>(stage)]),
      frames_(impl.scene.frames_in(static_cast<std::size_t>(stage))) {
  begin(impl.in_stage);
  reported_at_ = Clock::now();
  reported_steps_ = s_.stage_step;
  reported_fraction_ = s_.stage_fraction();
}

void StageRun::begin(bool was_in_stage) {
  const bool on_lattice = !s_.large_motion;
  if (!was_in_stage) s_.begin_stage(index_);
  if (!was_in_stage && settings_.kind == "rest") find_rest(simulation_, s_);
  if (on_lattice && s_.large_motion) observer_.on_promotion(simulation_);
  observer_.on_stage_begin(simulation_, index_);
  if (!was_in_stage) s_.warn_of_loose_blocks(&warnings_), warn();
  for (const LawSwap& swap : s_.swaps) observer_.on_law_swap(swap);
}

bool StageRun::advance() {
  const Due due = look_ahead();
  const bool done = has_ended(due);
  if (done) s_.step_once(true, true);  // so that the last row and what follows it are complete
  gone_over_ = false, frame_due_ = due.frame;
  // Before a row that only the stop asks for: who goes on from here has a history without it.
  const bool stop_between_rows = due.stop && !due.planned && !done;
  if (stop_between_rows) follow_motion(done), show_frame(), pause(true);
  if ((due.row && !gone_over_) || done) write_row(done);
  if (!stop_between_rows) follow_motion(done);
  if (due.check || due.row || done) s_.find_falling_block(&warnings_), warn();
  show_frame();
  if (due.stop && due.planned && !done) pause(true);
  if (due.stop)
    throw Error(Exit::interrupted, fmt::format("stopped at step {} of stage '{}'", s_.stage_step, settings_.name));
  if (!done) {
    require_steps_left();
    if (s_.stage_step % kPauseInterval == 0) pause(false);
    s_.balance_ranks();
  }
  report_progress();
  return done;
}

StageRun::Due StageRun::look_ahead() {
  s_.stop_wanted = simulation_.stop_requested();
  Due due;
  due.stop = s_.ranks ? s_.stop_agreed : s_.stop_wanted;
  due.check = settings_.equilibrium_ratio && s_.stage_step % kCheckInterval == 0;
  due.planned = s_.stage_step >= s_.next_row;
  due.row = due.stop || due.planned;
  due.frame = frames_ > 0 && s_.next_frame <= frames_ && s_.stage_fraction() * frames_ >= s_.next_frame;
  s_.sample_energy = s_.watch.pending || (due.planned && s_.begins_check());
  const bool count_crushed = due.row && s_.step_count >= s_.watch.next_flags;
  if (count_crushed) s_.watch.next_flags = Watch::after(s_.step_count);
  s_.step_once(due.check || due.row || due.frame || s_.books_energy() || s_.sample_energy, count_crushed || due.frame);
  return due;
}

// Each criterion is asked: what it finds out is kept, whichever of them ends the stage.
bool StageRun::has_ended(const Due& due) {
  bool ended = due.check && s_.equilibrium_reached(settings_);
  ended |= s_.stage_fraction() >= 1.0 || s_.force_lost();
  if (s_.large_motion && s_.stage_step % kCollapseInterval == 0) ended |= s_.collapse_ended(&warnings_);
  return ended;
}

void StageRun::follow_motion(bool done) {
  gone_over_ = s_.follow_motion(done, &warnings_);
  if (gone_over_) observer_.on_promotion(simulation_);
  warn();
}

void StageRun::show_frame() {
  if (!frame_due_) return;
  s_.fetch_for_frame();
  write([&] { observer_.on_frame(simulation_, index_, s_.next_frame++); });
  frame_due_ = false;
}

void StageRun::write_row(bool done) {
  s_.gather(Part::row);
  const auto before = Clock::now();
  const HistoryRow row = s_.measure();
  s_.times[Phase::measurement] += seconds_since(before);
  s_.require_finite(row);
  write([&] { observer_.on_row(row); });
  const auto watched = Clock::now();
  if (s_.large_motion) s_.check_rotations();
  if (done) s_.watch.next_stiffness = std::min(s_.watch.next_stiffness, s_.step_count);  // what ends a stage is seen
  const std::vector<Warning> of_watch = s_.look();
  warnings_.insert(warnings_.end(), of_watch.begin(), of_watch.end());
  s_.times[Phase::watch] += seconds_since(watched);
  warn();
  if (s_.next_row < s_.stage_step)
    s_.next_row += (s_.stage_step - s_.next_row + s_.row_interval - 1) / s_.row_interval * s_.row_interval;
}

void StageRun::pause(bool last) {
  if (!s_.any_rank(observer_.wants_pause(last))) return;
  if (!s_.in_parts) s_.gather(Part::all);
  std::optional<Error> fault;  // of one rank: all end then, together
  try {
    write([&] { observer_.on_pause(simulation_, last); });
  } catch (const Error& error) {
    fault = error;
  }
  if (s_.any_rank(fault.has_value()))
    throw fault ? *fault : Error(Exit::bad_input, "another rank could not keep what was computed");
}

void StageRun::require_steps_left() const {
  if (s_.stage_step < settings_.max_steps) return;
  std::string reason = fmt::format("stage '{}' has not ended after {} steps", settings_.name, s_.stage_step);
  if (settings_.equilibrium_ratio) {
    reason += fmt::format(": unbalanced force ratio {:.4g}, wanted {:.4g}", s_.unbalanced_ratio,
                          *settings_.equilibrium_ratio);
  }
  throw Error(Exit::numerical, reason + ". Raise max_steps, or find out what keeps moving");
}

void StageRun::report_progress() {
  if (s_.stage_step % kClockInterval != 0 || seconds_since(reported_at_) < kProgressPeriod) return;
  const double seconds = seconds_since(reported_at_), by_length = s_.stage_fraction();
  Progress progress;
  progress.stage = index_;
  progress.stage_count = static_cast<int>(s_.scene.stages.size());
  progress.settings = &settings_;
  progress.step = s_.stage_step;
  progress.unbalanced_ratio = s_.unbalanced_ratio;
  progress.fraction = by_length;
  if (settings_.equilibrium_ratio && s_.unbalanced_ratio > 0.0 && std::isfinite(s_.unbalanced_ratio) &&
      *settings_.equilibrium_ratio < 1.0) {
    progress.fraction = std::max(by_length, std::log(s_.unbalanced_ratio) / std::log(*settings_.equilibrium_ratio));
  }
  progress.fraction = std::clamp(progress.fraction, 0.0, 1.0);
  progress.steps_per_second = static_cast<double>(s_.stage_step - reported_steps_) / seconds;
  progress.seconds_left =
      by_length > reported_fraction_ ? seconds * (1.0 - by_length) / (by_length - reported_fraction_) : -1.0;
  observer_.on_progress(progress);
  reported_at_ = Clock::now();
  reported_steps_ = s_.stage_step;
  reported_fraction_ = by_length;
}

void StageRun::end() {
  if (!s_.in_parts) s_.gather(Part::all);
  // Frames that the end overtook: the last one shows the end.
  frame_due_ = frames_ > 0 && s_.next_frame <= frames_;
  show_frame();
  s_.gather(Part::row);
  s_.in_stage = false;
  observer_.on_stage_end(simulation_, index_, s_.measure());
}

void StageRun::warn() {
  for (const Warning& warning : warnings_) observer_.on_warning(warning);
  warnings_.clear();
}

}  // namespace quoin
