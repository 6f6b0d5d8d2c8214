// A simulation: owns the model and its state, and runs the stages of a scene.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/phase_clock.h"
#include "base/ranks.h"
#include "model/energies.h"
#include "model/model.h"
#include "model/time_step.h"
#include "scene/assembly.h"
#include "scene/scene.h"
#include "step/motion_bound.h"
#include "step/watch.h"

namespace quoin::blocks {
struct Model;
}

namespace quoin {

class ByteSource;

// Reaction of a support or of a prescribed motion: what it exerts on the joints of the blocks that it holds. Free
// components are 0. The weight of these blocks is not included.
struct Reaction {
  Vec3 force{};         // N
  Vec3 moment{};        // moment about the centre at the start, N m; of reaction_sum about the origin
  Vec3 displacement{};  // displacement since the start, m
};
constexpr std::size_t kMostRestraints = 12;  // most restraints with columns in a history

// Numbers of every row of the history. Forces include the symmetry factor: they are those of the whole wall.
struct HistoryNumbers {
  int stage = 0;
  long step = 0;              // number of steps since the start of the simulation
  double time = 0.0;          // time since the start of the simulation, s
  double displacement = 0.0;  // displacement of monitor or roof along Stage::direction since the start of the stage, m
  double resistance = 0.0;    // force along Stage::direction, N, positive when the wall resists: minus that of the
                              // joints on the monitor; with Stage::roof that on the monitor, which is the ground
  double vertical_force = 0.0;  // force between monitor and wall along y, compression positive, N
  Vec3 monitor_displacement{};  // displacement of monitor or roof since the start of the simulation, m
  Vec3 joint_force{};           // force of the joints on the bodies of the monitor, N
  double dynamic_force = 0.0;   // sum of reactions and loads along Stage::direction, and Members::unbalanced_strips,
                                // N; 0 at rest
  // Sum of all forces on rigid blocks of the monitor, along components that are free and not Stage::direction, N. It is
  // their inertia force there.
  double monitor_inertia = 0.0;
  double unbalanced_ratio = 0.0;  // largest unbalanced nodal force / mean contact force
  double kinetic_energy = 0.0;    // kinetic energy of the model as computed, J
  double multiplier = 0.0;        // multiplier of the body force in a collapse stage
  // Blocks in large motion, and bricks on the lattice where some stage goes beyond it (beyond_lattice):
  Vec3 ground_displacement{};  // displacement of the ground since the start, m
  Vec3 monitor_relative{};     // displacement of monitor or roof less that of the ground, m
  Vec3 base_force{};           // force of the structure on fixed blocks and on springs to the ground, N
  // Moment of contact forces on fixed blocks about the centre of the base, which moves with the ground, N m. NaN: there
  // is no base.
  Vec3 overturning_moment{NAN, NAN, NAN};
  // largest displacement of a block that is no support, since the start, m
  double largest_displacement = 0.0;
  std::optional<Energies> energies;                 // energies, with Scene::output.energy
  std::array<Reaction, kMostRestraints> reactions;  // reactions in the order of restraints_of (findings.h)
  Reaction reaction_sum;                            // sum over all supports
};

// A support or a prescribed motion, by the name of its blocks. Order: as stages name them, then named fixed blocks.
struct Restraint {
  std::string name;
  bool driven = false;  // moved by some stage
};

// One row of the history.
struct HistoryRow : HistoryNumbers {
  std::vector<double> added;  // values of added_columns (step/columns)
};

struct Progress {
  int stage = 0, stage_count = 0;
  const Stage* settings = nullptr;
  long step = 0;          // number of steps in this stage
  double fraction = 0.0;  // share of the stage that is done, 0..1, by the criterion closest to its end
  double steps_per_second = 0.0;
  double seconds_left = 0.0;  // time left in the stage; negative: not known yet
  double unbalanced_ratio = 0.0;
};

// The change from small displacements to large motion in mid-run. Every contact point keeps its traction and state.
struct Promotion {
  std::string why;  // motion bound that is exceeded, and where
  int stage = 0;
  long step = 0;
  double time = 0.0;           // time of the change, s
  double strain_energy = 0.0;  // strain energy of the zones before the change, J, as computed
  double energy_jump = 0.0;    // strain energy after less before, J
};

// Why a stage of cycles ended early.
struct StopAtForceLoss {
  int stage = 0, half_cycle = 0;      // indices from 0
  double force = 0.0, largest = 0.0;  // largest force of this half cycle, and of an earlier one to the same side, N
};

// Findings of the stages of a run.
struct Outcome {
  std::optional<Promotion> promotion;
  std::vector<Warning> warnings;  // violated assumptions, each once
  std::vector<StopAtForceLoss> force_losses;
  std::optional<double> collapse_multiplier;
  std::optional<double> base_slip_at_uplift;  // slip on fixed blocks, m, when a bed joint first opens by 0.1 mm
};

class Simulation;
struct Motion;

// A law swap: another law replaces that of a joint family, and every point keeps its traction.
struct LawSwap {
  std::string family, from, to;
  long points;
  long limited;          // number of points whose history the new law can hold only in part (status CLAMPED)
  double stored_before;  // elastic energy of the joints before, J, as computed
  double energy_jump;    // stored after less before, J
};

// Communication and costs of one rank over the steps of a run.
struct RankTraffic {
  double steps = 0.0, step_seconds = 0.0;  // wall time of all of run(), files included, s
  double halo_bytes = 0.0, halo_messages = 0.0;
  double own_seconds = 0.0;                    // processor time of contacts and motion, without waiting
  double waiting_seconds = 0.0;                // waiting for halos, and for what all ranks agree on
  double gathers = 0.0, gathered_bytes = 0.0;  // gathers on all ranks: rows, detection, checkpoints
  double gathering_seconds = 0.0;
  double blocks = 0.0;                       // blocks that this rank advances
  double points = 0.0, shared_points = 0.0;  // contact points evaluated here; those that other ranks evaluate too
  double peak_memory = 0.0;   // largest memory of the process until the end of run(), set-up included, bytes
  double repartitions = 0.0;  // repartitions because the work of the ranks was uneven
  double uneven_before = 0.0, uneven = 0.0;  // largest / mean work: before the first repartition, in the last window
};

// Callbacks of a run. They are called between steps, from the thread that runs the simulation.
struct Observer {
  virtual ~Observer() = default;
  virtual void on_stage_begin(const Simulation&, int /*stage*/) {}
  virtual void on_law_swap(const LawSwap&) {}
  virtual void on_warning(const Warning&) {}       // once for each violated assumption, where the run continues
  virtual void on_promotion(const Simulation&) {}  // details are in Simulation::outcome
  virtual void on_row(const HistoryRow&) {}
  // Whether on_pause saves the state. Where one rank's observer does, on_pause is called on all ranks, and all must
  // save.
  virtual bool wants_pause(bool /*last*/) { return true; }
  // A pause at which save() gives a checkpoint: all rows and frames before it are reported. last: the run stops here.
  virtual void on_pause(const Simulation&, bool /*last*/) {}
  virtual void on_progress(const Progress&) {}  // about four times a second
  // A frame of the stage; Scene::frames_in is their number, without those where damage grows. With ranks and
  // OutputSettings::pieces a rank then holds its own blocks alone, and the joints that touch them.
  virtual void on_frame(const Simulation&, int /*stage*/, int /*frame*/) {}
  virtual void on_stage_end(const Simulation&, int /*stage*/, const HistoryRow& /*last*/) {}
};

class Simulation {
 public:
  // Builds the model of a scene. threads 0: as many as the machine has. Laws are loaded by name.
  // ranks: several processes that advance one model, each built from the same scene; null: one process. They must
  // outlive the simulation. Results are bitwise identical with those of one process. run() calls the observers of all
  // ranks at the same steps. Only run() may be used to step.
  // Each rank holds its part of the model. collect_at_first sends results to rank 0. Rank 0 holds all of them after
  // gather_at_first(), and after a failure that all ranks have found. Throws Error(bad_input): the ranks have different
  // models.
  explicit Simulation(Scene scene, int threads = 1, Ranks* ranks = nullptr);
  // Builds the model of conforming bricks. materials: one a joint family, in place of laws loaded by name.
  Simulation(Scene scene, Assembly assembly, int threads = 1);
  Simulation(Scene scene, Assembly assembly, int threads, std::vector<std::shared_ptr<const Material>> materials);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // Runs all stages, or the rest of them. Throws Error(numerical) with place and values, or Error(interrupted) after
  // request_stop. Results can be read after either.
  void run(Observer& observer);
  // Runs the current stage, or the next one, to its end, but at most most_steps. A later call continues the stage, and
  // first reports it and its law swaps again. Returns false when all stages are over. Throws as run().
  bool run_stage(Observer& observer, long most_steps = std::numeric_limits<long>::max());
  // Async-signal-safe: the step in progress is finished first.
  void request_stop() noexcept { stop_requested_.store(true, std::memory_order_relaxed); }
  bool stop_requested() const noexcept { return stop_requested_.load(std::memory_order_relaxed); }

  // Advances by `steps` under the controls of the current stage (stage 0 before run), without a look at its end. With
  // measure_last, the last step records the numbers of measure() and the flags of contact points.
  void advance(long steps, bool measure_last = true);
  const Scene& scene() const;
  const Assembly& assembly() const;
  const Model& model() const;
  const blocks::Model* large_motion() const;  // blocks of any shape in large motion; null: none
  const Outcome& outcome() const;
  long block_count() const;
  long zone_count() const;
  long point_count() const;
  const TimeStepReport& time_step_report() const;
  int stage() const;         // index of the current stage, or of the last one; -1: none has begun
  int stages_ended() const;  // number of stages that are over
  long step() const;
  double time() const;
  int thread_count() const;
  std::uint64_t hash() const;  // hash of gridpoints, bodies, tractions and states: equal hashes, equal bits
  HistoryRow measure() const;  // row of the current state
  // A checkpoint: all data that change during a run, as bytes. restore throws Error(bad_input) when the bytes are of
  // another model. A restored run is bitwise identical with an uninterrupted one.
  std::vector<std::uint8_t> save() const;
  // Saves the same bytes in pieces: rank 0 calls `take` for each, in order. All ranks must call it at the same step, in
  // on_pause. No rank then holds more than some megabytes of the data of others.
  using TakeBytes = std::function<void(std::span<const std::uint8_t>)>;
  void save(const TakeBytes& take) const;
  std::size_t saved_bytes() const;
  void restore(const std::vector<std::uint8_t>& bytes);
  // Restores from a source of bytes, of which a rank reads its own part. All ranks call it. After an Error the
  // simulation is unusable.
  void restore(ByteSource& source);

  // Data of the simulation, for the functions of results.h, collect.h, findings.h and steer.h.
  struct Impl;  // state.h
  operator const Impl&() const { return *impl_; }
  operator Impl&() { return *impl_; }

 private:
  static std::unique_ptr<Impl> make_impl(Motion motion, int threads,
                                         std::vector<std::shared_ptr<const Material>> materials,
                                         Ranks* ranks = nullptr);
  std::unique_ptr<Impl> impl_;
  std::atomic<bool> stop_requested_{false};
};

}  // namespace quoin
