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
#include <utility>
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
struct Tangent;

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

// Condition of a contact point: exclusive; the first that holds, in this order.
enum class Condition : std::uint8_t { crushed_out, crushing, open, slipping, softening, elastic };
inline constexpr int kConditionCount = 6;
const char* condition_name(Condition condition);
Condition condition_of(std::uint32_t flags);  // QUOIN_FLAG_...

struct ContactPoint {
  std::int32_t index;  // index of the point, for Simulation::state
  Vec3 position;       // reference, m
  Vec3 normal, s, t;   // n from block a to block b
  double area;         // m2
  int joint, family;   // indices into the assembly
  int block_a, block_b;
  Vec3 jump;            // u_b - u_a along n, s, t at the time of the traction, m
  Vec3 traction;        // sigma, tau_s, tau_t, Pa
  std::uint32_t flags;  // QUOIN_FLAG_..., of the last step
  Condition condition;
};

// Neighbouring contact points, [first, end).
struct PointRange {
  std::int32_t first = 0, end = 0;
};

// An array that every step reads or writes.
enum class HotOf { block, rigid_body, contact_point };
struct HotArray {
  const char* what;
  HotOf of;
  std::size_t bytes;  // all of it
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
  // Time by phase since then, of every step; else of one step in kTimedSteps, taken so many times. On the lattice
  // internal forces and motion are one kernel, whose time is that of motion.
  void time_phases();
  const PhaseTimes& phase_times() const;
  std::vector<HotArray> hot_arrays() const;

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
  const char* instruction_set() const;    // chosen at run time: "AVX2"
  std::uint64_t hash() const;             // hash of gridpoints, bodies, tractions and states: equal hashes, equal bits
  HistoryRow measure() const;             // row of the current state
  const MotionSeen& motion_seen() const;  // motion at the last check of run()
  const Watch& watch() const;             // watch at the last row
  double allowed_overlap() const;         // m
  // The contact points of a batch, for messages, from any thread: "contact points 0 to 255 of joint family
  // 'mortar', from (0.100, 0.000, 0.050) m on".
  std::string batch_text(const quoin_batch& batch) const;
  std::string past_motion_bound() const;  // bound that is exceeded, and where; empty: none

  // What a stage holds or drives, "base: x y z" each. And the blocks that no joint of the start ties to anything that
  // is held against gravity.
  struct Supports {
    std::vector<std::string> held;
    std::vector<int> loose;
  };
  Supports supports(int stage) const;
  std::string block_label(int block) const;  // name of the block in messages
  // Those with columns in the history; empty where there are more than it can.
  const std::vector<Restraint>& restraints() const;

  // Results by block. Cold.
  struct BlockMesh {
    std::vector<Vec3> gridpoint;  // places at the start, m; rigid blocks: the corners (bricks: x fastest, then y, z)
    std::vector<std::array<int, 4>> zone;  // tetrahedra; empty for rigid blocks
    std::vector<std::vector<int>> face;    // faces of the whole block, corner by corner, counter-clockwise from outside
    int unit = -1, course = -1;            // place in the masonry; -1: none
    bool fixed = false;                    // a support, or a beam beside the masonry
  };
  BlockMesh block_mesh(int block) const;
  struct BlockSize {
    std::uint64_t gridpoints = 0, zones = 0, faces = 0, face_corners = 0;
  };
  BlockSize block_size(int block) const;                  // size of its mesh
  std::vector<Vec3> block_displacement(int block) const;  // per gridpoint of block_mesh, m
  std::vector<Vec3> block_velocity(int block) const;
  std::vector<std::array<double, 6>> block_stress(int block) const;  // per zone: xx yy zz xy yz zx, Pa, tension > 0

  // Results by contact point, of some of them or of all. Cold: flags come from a batch with zero increments, into
  // scratch.
  PointRange all_points() const;
  // own_alone: of joints that begin at a block of this rank (owns_block).
  std::vector<ContactPoint> contact_points(const PointRange& range, bool own_alone = false) const;
  std::vector<ContactPoint> contact_points() const { return contact_points(all_points()); }
  // Displacements of the gridpoints that it joins, of block a and block b, m. On the lattice.
  std::pair<Vec3, Vec3> displacement_of_sides(std::int32_t point) const;
  // Column of a law state, by id; NaN where the law of a point has no such state or does not keep it.
  std::vector<double> state(const std::string& id, const PointRange& range) const;
  std::vector<double> state(const std::string& id) const { return state(id, all_points()); }
  bool keeps_state(const std::string& id) const;  // the law of some point
  // Share of what tensile strength, cohesion and compressive strength can lose that is lost; NaN where the law of a
  // point does not have. Cold, as contact_points.
  using DamageColumns = std::array<std::vector<double>, QUOIN_DAMAGE_COUNT>;
  DamageColumns damage(const PointRange& range) const;
  DamageColumns damage() const { return damage(all_points()); }
  std::array<long, kConditionCount> condition_counts() const;

  // Steering between two steps (steer.cpp), from now on and until the next stage begins; without a ramp. What the stage
  // does not hold along a component has no velocity to be given, what it holds takes no force. Before the first step
  // the first stage is begun. Each throws Error(bad_input) with what the scene has instead, and nothing has changed
  // then.
  void set_velocity(const std::string& body, const Vec3& velocity);  // m/s; components that are free keep theirs: NaN
  void set_force(const std::string& body, const Vec3& force);        // N, on each body of that name; held ones: NaN
  // The tractions of all points stay. Throws Error(law_refused) too.
  LawSwap swap_law(const std::string& family, const std::string& law);

  // Where arrays of now lie, in doubles: row r, column c at data[r * row_stride + c * column_stride]. Good until the
  // simulation is stepped, steered or restored. data null: there is none, as displacements in large motion.
  struct View {
    double* data = nullptr;
    std::size_t rows = 0, columns = 1;
    std::ptrdiff_t row_stride = 1, column_stride = 1;
  };
  enum class BlockArray { displacement, velocity };  // m, m/s
  // By gridpoint, x y z; of a rigid block one row: its centre.
  View view(BlockArray what, int block);
  enum class PointArray { sigma, tau_s, tau_t, area, position };  // Pa, m2, m (reference on the lattice, else now)
  View view(PointArray what, int family);
  View view_state(int family, const std::string& id);  // Error(bad_input): the law has no such state
  // To be called after velocities were written through a view.
  void velocities_changed();

  // Results of all by one process after the other, so that none needs all of it (collect.cpp).
  // Neighbouring blocks, contact points or joints, [first, end), some hundred or thousand, of which one rank has what
  // results are made of. Runs follow each other in order.
  struct Run {
    std::int32_t first = 0, end = 0;
    int rank = 0;
  };
  std::vector<Run> runs_of_blocks() const;
  std::vector<Run> runs_of_points() const;  // whole batches of their laws
  std::vector<Run> runs_of_joints() const;  // runs of joints on the lattice, with all of their points
  bool brings(const Run& run) const;        // this rank makes of it what rank 0 takes
  // make: by the rank that has the run; take: by rank 0, in the order of runs. All ranks call it at the same moment:
  // in on_frame, or after run(). Where rank 0 has all of the state it makes everything, and others do nothing.
  void collect_at_first(std::span<const Run> runs, const std::function<std::string(const Run&)>& make,
                        const std::function<void(const std::string&)>& take) const;
  bool ranks_collect() const;                 // false: one process, or rank 0 has all
  double sum_of_ranks(double brought) const;  // sum of the values of all ranks
  double largest_of_ranks(double brought) const;
  // So that rank 0 has all from now on. All ranks call it at the same moment.
  void gather_at_first();
  // In order, those of joints that begin at a block of this rank.
  void each_own_point(const std::function<void(std::int32_t)>& visit) const;

  bool owns_block(int block) const;                      // advances it; true: one process
  const std::vector<RankTraffic>& rank_traffic() const;  // by rank, of run(); empty: one process
  bool ranks_together() const;                           // false: run() has failed on some ranks and not on others

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

  // Raw access for tests: displacement and velocity in lane layout.
  LaneVector<double>& displacement();
  LaneVector<double>& velocity();

  struct Impl;  // state.h

 private:
  friend Tangent tangent_of(const Simulation& simulation);  // step/tangent.h
  static std::unique_ptr<Impl> make_impl(Motion motion, int threads,
                                         std::vector<std::shared_ptr<const Material>> materials,
                                         Ranks* ranks = nullptr);
  std::unique_ptr<Impl> impl_;
  std::atomic<bool> stop_requested_{false};
};

}  // namespace quoin
