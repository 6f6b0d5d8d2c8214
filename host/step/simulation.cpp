#include "step/simulation.h"

#include "model/motion.h"
#include "step/findings.h"
#include "step/gather.h"
#include "step/measure.h"
#include "step/rank_agreement.h"
#include "step/rank_load.h"
#include "step/rest.h"
#include "step/run_watch.h"
#include "step/set_up.h"
#include "step/small_motion.h"
#include "step/stage_run.h"
#include "step/stages.h"
#include "step/state.h"
#include "step/state_hash.h"
#include "step/step.h"

namespace quoin {

namespace {

constexpr double kTogether = 5.0;  // s; time within which ranks that fail together have all failed

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
  auto impl = std::make_unique<Impl>(std::move(motion.scene), threads, ranks);
  set_up(*impl, std::move(motion.bricks), std::move(materials), motion.shapes ? &*motion.shapes : nullptr);
  return impl;
}

Simulation::~Simulation() = default;

namespace {

// At the end of its scope velocities of blocks in large motion are current, whichever step was the last.
struct CurrentVelocities {
  Simulation::Impl& s;
  ~CurrentVelocities() {
    if (s.large_motion) copy_velocities(*s.large_motion);
  }
};

}  // namespace

void Simulation::advance(long steps, bool measure_last) {
  const CurrentVelocities current{*impl_};
  if (impl_->progress.stage < 0 && !impl_->scene.stages.empty()) begin_stage(*impl_, 0);
  for (long i = 0; i < steps; ++i) {
    const bool last = measure_last && i + 1 == steps;
    step_once(*impl_, books_energy(*impl_) || last, last);
  }
}

void Simulation::run(Observer& observer) {
  impl_->rank_load.run_start = Clock::now();
  try {
    while (run_stage(observer)) {
    }
  } catch (const Error& error) {
    if (impl_->ranks) impl_->agreed.together = impl_->ranks->all_here(kTogether);
    if (impl_->agreed.together) {
      // All ranks have ended: after a failure rank 0 gathers the state, after a stop the results of an end suffice.
      if (any_rank(*impl_, error.exit_code != Exit::interrupted))
        gather(*impl_, Part::all, Who::first);
      else
        end_run(*impl_);
      collect_traffic(*impl_);
    }
    throw;
  }
  end_run(*impl_);
  collect_traffic(*impl_);
}

bool Simulation::run_stage(Observer& observer, long most_steps) {
  const int stages = static_cast<int>(impl_->scene.stages.size());
  const int index = stages_ended();
  if (index >= stages) return false;
  require_coming_stages(*this);
  const CurrentVelocities current{*impl_};
  StageRun stage(*this, *impl_, observer, index);
  for (; most_steps > 0; --most_steps) {
    if (!stage.advance()) continue;
    stage.end();
    return index + 1 < stages;
  }
  return true;
}

void time_phases(Simulation::Impl& s) {
  s.timing.every_step = true;
  s.timing.phases = {};
}
const PhaseTimes& phase_times(const Simulation::Impl& s) { return s.timing.phases; }
const Scene& Simulation::scene() const { return impl_->scene; }
const Assembly& Simulation::assembly() const { return impl_->model.assembly; }
const Model& Simulation::model() const { return impl_->model; }
const TimeStepReport& Simulation::time_step_report() const { return impl_->time_step; }
int Simulation::stage() const { return impl_->progress.stage; }
int Simulation::stages_ended() const { return stage() + (impl_->progress.in_stage ? 0 : 1); }
long Simulation::step() const { return impl_->progress.step; }
double Simulation::time() const { return time_now(*impl_); }
const blocks::Model* Simulation::large_motion() const { return impl_->large_motion.get(); }
const Outcome& Simulation::outcome() const { return impl_->outcome; }
int Simulation::thread_count() const { return impl_->pool.thread_count(); }
HistoryRow Simulation::measure() const { return measure_row(*impl_); }
const MotionSeen& motion_seen(const Simulation::Impl& s) { return s.small_motion.seen; }
const Watch& watch_of(const Simulation::Impl& s) { return s.watch; }
const std::vector<Restraint>& restraints_of(const Simulation::Impl& s) { return s.reactions.restraints; }

}  // namespace quoin
