#include "step/simulation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "model/motion.h"
#include "step/stage_run.h"
#include "step/state.h"

namespace quoin {

namespace {

constexpr double kTogether = 5.0;  // s, within which ranks that fail together have all failed

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
      // All ranks share what they have found. A rank that was only asked to stop has nothing to share.
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
  const int stages = static_cast<int>(impl_->scene.stages.size());
  const int index = impl_->stage < 0 ? 0 : impl_->in_stage ? impl_->stage : impl_->stage + 1;
  if (index >= stages) return false;
  StageRun stage(*this, *impl_, observer, index);
  for (; most_steps > 0; --most_steps) {
    if (!stage.advance()) continue;
    stage.end();
    return index + 1 < stages;
  }
  return true;
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
