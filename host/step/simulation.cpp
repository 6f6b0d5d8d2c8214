#include "step/simulation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "model/motion.h"
#include "step/rest.h"
#include "step/state.h"

namespace quoin {

namespace {

constexpr long kCollapseInterval = 10;    // steps between two looks at how far blocks have moved
constexpr long kPauseInterval = 16;       // steps between two moments at which a checkpoint may be taken
constexpr double kProgressPeriod = 0.25;  // s
constexpr double kTogether = 5.0;         // s, within which ranks that fail together have all failed

}  // namespace

Simulation::Simulation(Scene scene, int threads, Ranks* ranks) {
  Motion motion = choose_motion(std::move(scene));
  auto materials = make_materials(motion.bricks);
  impl_ = make_impl(std::move(motion), threads, std::move(materials), ranks);
}

Simulation::Simulation(Scene scene, Assembly assembly, int threads) {
  auto materials = make_materials(assembly);
  impl_ = make_impl(choose_motion(std::move(scene), std::move(assembly)), threads, std::move(materials));
}

Simulation::Simulation(Scene scene, Assembly assembly, int threads,
                       std::vector<std::shared_ptr<const Material>> materials)
    : impl_(make_impl(choose_motion(std::move(scene), std::move(assembly)), threads, std::move(materials))) {}

std::unique_ptr<Simulation::Impl> Simulation::make_impl(Motion motion, int threads,
                                                        std::vector<std::shared_ptr<const Material>> materials,
                                                        Ranks* ranks) {
  return std::make_unique<Impl>(std::move(motion.scene), std::move(motion.bricks), threads, std::move(materials),
                                motion.shapes ? &*motion.shapes : nullptr, ranks);
}

Simulation::~Simulation() = default;

void Simulation::advance(long steps, bool measure_last) {
  if (impl_->stage < 0 && !impl_->scene.stages.empty()) impl_->begin_stage(0);
  for (long i = 0; i < steps; ++i) {
    const bool last = measure_last && i + 1 == steps;
    impl_->step_once(impl_->books_energy() || last, last);
  }
}

void Simulation::run(Observer& observer) {
  impl_->run_start = Clock::now();
  try {
    while (run_stage(observer)) {
    }
  } catch (const Error& error) {
    if (impl_->ranks) impl_->together = impl_->ranks->all_here(kTogether);
    if (impl_->together) {
      // What all ranks have found is told with all that they know. Who was only asked to stop has nothing to find.
      if (impl_->any_rank(error.exit_code != Exit::interrupted))
        impl_->gather(Part::all, Who::first);
      else
        impl_->end_run();
      impl_->collect_traffic();
    }
    throw;
  }
  impl_->end_run();
  impl_->collect_traffic();
}

bool Simulation::run_stage(Observer& observer, long most_steps) {
  Impl& s = *impl_;
  const auto tell = [&s](const auto& what) {
    const auto before = Clock::now();
    what();
    s.times[Phase::output] += seconds_since(before);
  };
  const auto pause = [&](bool last) {
    if (!s.any_rank(observer.wants_pause(last))) return;
    if (!s.in_parts) s.gather(Part::all);
    std::optional<Error> fault;  // of one rank: all end then, together
    try {
      tell([&] { observer.on_pause(*this, last); });
    } catch (const Error& error) {
      fault = error;
    }
    if (s.any_rank(fault.has_value()))
      throw fault ? *fault : Error(Exit::bad_input, "another rank could not keep what was computed");
  };
  const int stage_count = static_cast<int>(s.scene.stages.size());
  const int index = s.stage < 0 ? 0 : s.in_stage ? s.stage : s.stage + 1;
  if (index >= stage_count) return false;
  const bool begins = !s.in_stage;
  const bool on_lattice = !s.large_motion;
  if (begins) s.begin_stage(index);
  if (begins && s.scene.stages[static_cast<std::size_t>(index)].kind == "rest") find_rest(*this, s);
  if (on_lattice && s.large_motion) observer.on_promotion(*this);
  observer.on_stage_begin(*this, index);
  std::vector<Warning> warnings;
  const auto warn = [&] {
    for (const Warning& warning : warnings) observer.on_warning(warning);
    warnings.clear();
  };
  if (begins) s.warn_of_loose_blocks(&warnings), warn();
  for (const LawSwap& swap : s.swaps) observer.on_law_swap(swap);
  const Stage& settings = s.scene.stages[static_cast<std::size_t>(index)];
  const int frames = s.scene.frames_in(static_cast<std::size_t>(index));
  auto last_progress = Clock::now();
  long steps_then = s.stage_step;
  double fraction_then = s.stage_fraction();

  for (bool done = false; !done; --most_steps) {
    if (most_steps <= 0) return true;
    s.stop_wanted = stop_requested();
    const bool stop = s.ranks ? s.stop_agreed : s.stop_wanted;
    const bool check = settings.equilibrium_ratio && s.stage_step % kCheckInterval == 0;
    const bool due = s.stage_step >= s.next_row, row = stop || due;
    const bool frame = frames > 0 && s.next_frame <= frames && s.stage_fraction() * frames >= s.next_frame;
    s.sample_energy = s.watch.pending || (due && s.begin_look());
    const bool count_crushed = row && s.step_count >= s.watch.next_flags;
    if (count_crushed) s.watch.next_flags = Watch::after(s.step_count);
    s.step_once(check || row || frame || s.books_energy() || s.sample_energy, count_crushed || frame);

    done = check && s.equilibrium_reached(settings);
    if (s.stage_fraction() >= 1.0 || s.force_lost()) done = true;
    if (s.large_motion && s.stage_step % kCollapseInterval == 0 && s.collapse_ended(&warnings)) done = true;
    if (done) s.step_once(true, true);  // so that the last row and what follows it are complete
    bool show = frame;
    const auto show_frame = [&] {
      if (show) s.fetch_for_frame(), tell([&] { observer.on_frame(*this, index, s.next_frame++); });
      show = false;
    };
    bool gone_over = false;
    const auto follow_motion = [&] {
      gone_over = s.follow_motion(done, &warnings);
      if (gone_over) observer.on_promotion(*this);
      warn();
    };
    // Before a row that only the stop asks for: who goes on from here has a history without it.
    const bool stop_between_rows = stop && !due && !done;
    if (stop_between_rows) follow_motion(), show_frame(), pause(true);
    if ((row && !gone_over) || done) {
      s.gather(Part::row);
      const auto before = Clock::now();
      const HistoryRow now = s.measure();
      s.times[Phase::measurement] += seconds_since(before);
      s.require_finite(now);
      tell([&] { observer.on_row(now); });
      const auto watched = Clock::now();
      if (s.large_motion) s.look_at_rotations();
      if (done) s.watch.next_stiffness = std::min(s.watch.next_stiffness, s.step_count);  // what ends a stage is seen
      const std::vector<Warning> of_watch = s.look();
      warnings.insert(warnings.end(), of_watch.begin(), of_watch.end());
      s.times[Phase::watch] += seconds_since(watched);
      warn();
      if (s.next_row < s.stage_step)
        s.next_row += (s.stage_step - s.next_row + s.row_interval - 1) / s.row_interval * s.row_interval;
    }
    if (!stop_between_rows) follow_motion();
    if (check || row || done) s.look_for_falling_block(&warnings), warn();
    show_frame();
    if (stop && due && !done) pause(true);
    if (stop)
      throw Error(Exit::interrupted, fmt::format("stopped at step {} of stage '{}'", s.stage_step, settings.name));
    if (!done && s.stage_step >= settings.max_steps) {
      std::string reason = fmt::format("stage '{}' has not ended after {} steps", settings.name, s.stage_step);
      if (settings.equilibrium_ratio) {
        reason += fmt::format(": unbalanced force ratio {:.4g}, wanted {:.4g}", s.unbalanced_ratio,
                              *settings.equilibrium_ratio);
      }
      throw Error(Exit::numerical, reason + ". Raise max_steps, or find out what keeps moving");
    }
    if (!done && s.stage_step % kPauseInterval == 0) pause(false);
    if (!done) s.balance_ranks();
    if ((s.stage_step & 63) == 0 && seconds_since(last_progress) >= kProgressPeriod) {
      const double seconds = seconds_since(last_progress);
      Progress progress;
      progress.stage = index;
      progress.stage_count = stage_count;
      progress.settings = &settings;
      progress.step = s.stage_step;
      progress.unbalanced_ratio = s.unbalanced_ratio;
      const double by_length = s.stage_fraction();
      progress.fraction = by_length;
      if (settings.equilibrium_ratio && s.unbalanced_ratio > 0.0 && std::isfinite(s.unbalanced_ratio) &&
          *settings.equilibrium_ratio < 1.0) {
        progress.fraction = std::max(by_length, std::log(s.unbalanced_ratio) / std::log(*settings.equilibrium_ratio));
      }
      progress.fraction = std::clamp(progress.fraction, 0.0, 1.0);
      progress.steps_per_second = static_cast<double>(s.stage_step - steps_then) / seconds;
      progress.seconds_left =
          by_length > fraction_then ? seconds * (1.0 - by_length) / (by_length - fraction_then) : -1.0;
      observer.on_progress(progress);
      last_progress = Clock::now();
      steps_then = s.stage_step;
      fraction_then = by_length;
    }
  }
  if (!s.in_parts) s.gather(Part::all);
  // Frames that the end overtook: the last one shows the end.
  if (frames > 0 && s.next_frame <= frames)
    s.fetch_for_frame(), tell([&] { observer.on_frame(*this, index, s.next_frame++); });
  s.gather(Part::row);
  s.in_stage = false;
  observer.on_stage_end(*this, index, s.measure());
  return index + 1 < stage_count;
}

void Simulation::time_phases() {
  impl_->time_every_step = true;
  impl_->times = {};
}
const PhaseTimes& Simulation::phase_times() const { return impl_->times; }
const Scene& Simulation::scene() const { return impl_->scene; }
const Assembly& Simulation::assembly() const { return impl_->model.assembly; }
const Model& Simulation::model() const { return impl_->model; }
const TimeStepReport& Simulation::time_step_report() const { return impl_->time_step; }
long Simulation::step() const { return impl_->step_count; }
double Simulation::time() const { return impl_->now(); }
const blocks::Model* Simulation::large_motion() const { return impl_->large_motion.get(); }
const Outcome& Simulation::outcome() const { return impl_->outcome; }
int Simulation::thread_count() const { return impl_->pool.thread_count(); }
const char* Simulation::instruction_set() const { return kernel_instruction_set(); }
HistoryRow Simulation::measure() const { return impl_->measure(); }
const MotionSeen& Simulation::motion_seen() const { return impl_->motion_seen; }
std::string Simulation::batch_text(const quoin_batch& batch) const { return impl_->batch_text(batch); }
const Watch& Simulation::watch() const { return impl_->watch; }
const std::vector<Restraint>& Simulation::restraints() const { return impl_->restraints; }
double Simulation::allowed_overlap() const { return impl_->allowed_overlap(); }
std::string Simulation::past_motion_bound() const { return impl_->past_motion_bound(); }
LaneVector<double>& Simulation::displacement() { return impl_->displacement; }
LaneVector<double>& Simulation::velocity() { return impl_->velocity; }

}  // namespace quoin
