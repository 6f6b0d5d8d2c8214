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

// Energies of the model as computed (not multiplied by the symmetry factor), J. Closure:
// kinetic + strain + contact_stored + dissipated + damping = external (+ what they were at the start).
struct Energies {
  double kinetic = 0.0;
  double strain = 0.0;                 // zones
  double contact_stored = 0.0;         // joints, recoverable
  std::array<double, 4> dissipated{};  // joints since the start: tension, cohesion, friction, crushing
  double external = 0.0;               // work of weight, forces and prescribed velocities since the start
  double damping = 0.0;                // work taken by damping since the start
  double detection = 0.0;              // stored energy lost (> 0) or gained where contact points were placed again
  double members_stored = 0.0, members_dissipated = 0.0;  // ties
  double balance_error() const {
    return kinetic + strain + contact_stored + members_stored + dissipated[0] + dissipated[1] + dissipated[2] +
           dissipated[3] + members_dissipated + damping + detection - external;
  }
};

// What a support, or what drives a block, gives to the joints of what it holds; 0 along what is free. Its own weight is
// not in it.
struct Reaction {
  Vec3 force{};         // N
  Vec3 moment{};        // about the centre at the start, N m; of the sum of all about the origin
  Vec3 displacement{};  // displacement since the start, m
};
constexpr std::size_t kMostRestraints = 12;  // columns of a history, one each

// The numbers that every line of the history has. Forces include the symmetry factor: they are those of the whole wall.
struct HistoryNumbers {
  int stage = 0;
  long step = 0;                  // number of steps since the start of the simulation
  double time = 0.0;              // s, since the start of the simulation
  double displacement = 0.0;      // displacement of the monitor along Stage::direction since the start of the stage, m
  double resistance = 0.0;        // minus the force of the joints on the monitor along Stage::direction, N: positive
                                  // when the wall resists a movement in the positive direction
  double vertical_force = 0.0;    // force between monitor and wall along y, compression positive, N
  Vec3 monitor_displacement{};    // displacement since the start of the simulation, m
  Vec3 joint_force{};             // force of the joints on the bodies of the monitor, N
  double dynamic_force = 0.0;     // along Stage::direction: what supports and loads give in all, N; 0 at rest
  double unbalanced_ratio = 0.0;  // largest unbalanced nodal force / mean contact force
  double kinetic_energy = 0.0;    // J, of the model as computed
  double multiplier = 0.0;        // multiplier of the body force in a collapse stage
  // Blocks in large motion only:
  Vec3 ground_displacement{};  // displacement since the start, m
  Vec3 monitor_relative{};     // displacement of the monitor less that of the ground, m
  Vec3 base_force{};           // force on the fixed blocks by what stands on them, N
  // Moment of these about the centre of the base, which moves with the ground, N m; not a number where ranks share
  // points.
  Vec3 overturning_moment{NAN, NAN, NAN};
  double largest_displacement = 0.0;  // largest displacement of a block since the start, m; blocks of any shape alone
  std::optional<Energies> energies;   // energies, with Scene::output.energy
  std::array<Reaction, kMostRestraints> reactions;  // values for Simulation::restraints
  Reaction reaction_sum;                            // sum over these and all other supports
};

// A support, or what drives blocks: by name, in the order in which stages name them, then fixed blocks that have one.
struct Restraint {
  std::string name;
  bool driven = false;  // by some stage
};

// One line of the history.
struct HistoryRow : HistoryNumbers {
  std::vector<double> added;  // by added_columns (step/columns)
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

// From small displacements to large motion in mid-run, with the traction and state of every contact point kept.
struct Promotion {
  std::string why;  // bound that was passed, and where
  int stage = 0;
  long step = 0;
  double time = 0.0;           // s
  double strain_energy = 0.0;  // strain energy of the zones before, J, as computed
  double energy_jump = 0.0;    // after less before, J
};

// Why a stage of cycles ended early.
struct StopAtForceLoss {
  int stage = 0, half_cycle = 0;      // indices from 0
  double force = 0.0, largest = 0.0;  // largest forces then, and in an earlier half cycle to the same side, N
};

// What stages found out.
struct Outcome {
  std::optional<Promotion> promotion;
  std::vector<Warning> warnings;  // assumptions that were left, each once
  std::vector<StopAtForceLoss> force_losses;
  std::optional<double> collapse_multiplier;
  std::optional<double> base_slip_at_uplift;  // m: of blocks on fixed ones, when a bed joint first opens by 0.1 mm
};

class Simulation;
struct Motion;

// A law that has replaced another one with the traction of every point kept.
struct LawSwap {
  std::string family, from, to;
  long points;
  long limited;          // points whose history the new law can hold only in part (status CLAMPED)
  double stored_before;  // elastic energy of the joints, J, for the modelled part
  double energy_jump;    // stored after less before, J
};

// What one of several processes has sent and waited for, in the steps of a run.
struct RankTraffic {
  double steps = 0.0, step_seconds = 0.0;  // s: all of run(), files included
  double halo_bytes = 0.0, halo_messages = 0.0;
  double own_seconds = 0.0;                    // processor time of contacts and motion, without waiting
  double waiting_seconds = 0.0;                // time for the halo of others, and to agree
  double gathers = 0.0, gathered_bytes = 0.0;  // gathers on all ranks: rows, detection, checkpoints
  double gathering_seconds = 0.0;
  double blocks = 0.0;                       // blocks that it advances
  double points = 0.0, shared_points = 0.0;  // contact points that it evaluates, and of them those that others do too
  double peak_memory = 0.0;                  // bytes: most of its process until the end of run(), set-up included
  double repartitions = 0.0;                 // times, because the ranks' own work was uneven
  double uneven_before = 0.0, uneven = 0.0;  // most / mean of it: before the first of them, in the last window; 0: none
};

// What the caller requests. All calls come from the thread that runs the simulation, between steps.
struct Observer {
  virtual ~Observer() = default;
  virtual void on_stage_begin(const Simulation&, int /*stage*/) {}
  virtual void on_law_swap(const LawSwap&) {}
  virtual void on_warning(const Warning&) {}       // once for each assumption that the run leaves, when it goes on
  virtual void on_promotion(const Simulation&) {}  // Simulation::outcome has more
  virtual void on_row(const HistoryRow&) {}
  // Whether on_pause will take the state: with ranks it is called on all of them, and all of them must save.
  virtual bool wants_pause(bool /*last*/) { return true; }
  // A moment whose save() a run may go on from, with every row and frame until then reported; last: the run stops here.
  virtual void on_pause(const Simulation&, bool /*last*/) {}
  virtual void on_progress(const Progress&) {}  // about four times a second
  // Scene::frames_in of each stage, numbered in it. With ranks and OutputSettings::pieces a rank then has its own
  // blocks alone, and the joints that touch them.
  virtual void on_frame(const Simulation&, int /*stage*/, int /*frame*/) {}
  virtual void on_stage_end(const Simulation&, int /*stage*/, const HistoryRow& /*last*/) {}
};

class Simulation {
 public:
  // Everything that the scene holds. threads 0: as many as the machine has. Laws are found by their names.
  // ranks: this is one of several processes that advance the model together, each made from the same scene. The bits
  // are those of one process. run() then calls observers of all ranks at the same steps. Each rank has what it holds;
  // results of all are gathered on rank 0 (collect_at_first). It has all after gather_at_first(), after a failure that
  // all ranks have found, and in large motion. Only run() may be used to step. Throws Error(bad_input): the ranks have
  // different models. Ranks must outlive the simulation; null: one process.
  explicit Simulation(Scene scene, int threads = 1, Ranks* ranks = nullptr);
  // An assembly of conforming bricks; or pass materials, one a joint family.
  Simulation(Scene scene, Assembly assembly, int threads = 1);
  Simulation(Scene scene, Assembly assembly, int threads, std::vector<std::shared_ptr<const Material>> materials);
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  // All stages, or the rest of them. Throws Error(numerical) with place and values, or Error(interrupted) after
  // request_stop; results can still be read then.
  void run(Observer& observer);
  // The current stage, or the next one: to its end, or for so many steps if it lasts longer. A later call goes on where
  // this one left, and begins by reporting the stage and its law swaps again. False: all stages are over. Throws as
  // run.
  bool run_stage(Observer& observer, long most_steps = std::numeric_limits<long>::max());
  // Async-signal-safe: the step in progress is finished first.
  void request_stop() noexcept { stop_requested_.store(true, std::memory_order_relaxed); }
  bool stop_requested() const noexcept { return stop_requested_.load(std::memory_order_relaxed); }

  // n steps under the controls of the current stage (stage 0 before run); for tests and benchmarks. With measure_last,
  // the last of them records what measure() and the flags of contact points report.
  void advance(long steps, bool measure_last = true);
  const Scene& scene() const;
  const Assembly& assembly() const;
  const Model& model() const;
  const blocks::Model* large_motion() const;  // blocks of any shape; null: none
  const Outcome& outcome() const;
  long block_count() const;
  long zone_count() const;
  long point_count() const;
  const TimeStepReport& time_step_report() const;
  long step() const;
  double time() const;
  int thread_count() const;
  std::uint64_t hash() const;  // hash of gridpoints, bodies, tractions and states: equal hashes, equal bits
  HistoryRow measure() const;  // row of the current state
  // Everything that changes during a run, as bytes: a checkpoint. restore throws Error(bad_input) when the bytes come
  // from another model. Bits after a restore are those of an uninterrupted run.
  std::vector<std::uint8_t> save() const;
  // The same piece by piece, which take gets in order. All ranks must call it at the same moment, in on_pause; rank 0
  // takes, and none has more than some megabytes of what others hold.
  using TakeBytes = std::function<void(std::span<const std::uint8_t>)>;
  void save(const TakeBytes& take) const;
  std::size_t saved_bytes() const;
  void restore(const std::vector<std::uint8_t>& bytes);
  // The same from where the bytes are, of which a rank takes what it holds. All ranks call it. After an Error the
  // simulation is of no use.
  void restore(ByteSource& source);

  // All that it has, for the functions on it: results.h, collect.h, findings.h, steer.h.
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
