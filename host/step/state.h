// The state of a simulation and the pieces of a step; private to this folder.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/archive.h"
#include "base/smooth_step.h"
#include "base/thread_pool.h"
#include "law/answers.h"
#include "model/shared_model.h"
#include "step/implicit_contacts.h"
#include "step/kernels.h"
#include "step/large_motion.h"
#include "step/motion_bound.h"
#include "step/rank_balance.h"
#include "step/rank_share.h"
#include "step/simulation.h"
#include "step/unjoined_blocks.h"

namespace quoin {

// One step in so many is timed phase by phase: a percent of a step, and no more. A prime: what comes at round
// intervals, such as looks at motion, falls on timed steps as often as on others.
constexpr long kTimedSteps = 31;
constexpr long kCheckInterval = 20;  // steps between two looks at the unbalanced force, or at a force that is lost

using Clock = std::chrono::steady_clock;
inline double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Rigid bodies in motion, one a lane: those of a group, or a lone one in lane 0. Rotations are small: a vector.
struct BodyLanes {
  using Quantity = double[3][kLanes];
  alignas(64) Quantity displacement = {}, rotation = {};  // m, rad
  Quantity velocity = {}, spin = {};                      // m/s, rad/s; of half a step ago

  // What controls impose in this step.
  Quantity applied_force = {};        // N
  Quantity prescribed_velocity = {};  // m/s
  double prescribed[6][kLanes] = {};  // 1: translations have this velocity, rotations are held; else 0
  bool any_prescribed = false;
  bool at_rest = false;  // and held there: a step changes nothing
};

struct CrackedBlock;

// Control of a body through a stage: over the ramp from the velocity and force before it to those of the stage.
struct BodyRamp {
  Vec3 velocity_from{}, velocity_to{};
  Vec3 force_from{}, force_to{};
  Vec3 in_cycles{};             // 1: this component follows the cycles of the stage; else 0
  std::uint64_t of_ground = 0;  // as in Drive
  std::int64_t motion = 0;      // as in Drive
};

// A deformable block that controls can load.
struct LoadedBlock {
  int block = -1;
  double mass = 0.0;  // kg, without scaling
};

// Whether the first multiplier of a collapse stage is carried. After its ramp the blocks then have stood for as long as
// the multiplier takes to grow by a hundredth. They have stood four times as long as a fall by what counts as collapse,
// too. Else what moves them later may be what the ramp has set in motion.
struct FirstLoad {
  double since = -1.0;                 // s, in the stage; < 0: not looked at yet
  double lowest = 0.0, highest = 0.0;  // largest displacement of a block since then, m
  bool carried = false;
  void look(double time, double moved, double allowed, double needed);   // s, m, m, s
  static double time_of(const Collapse& collapse, const Vec3& gravity);  // s
};

// Steps of this rank since the last look at how even the ranks are.
struct RankWindow {
  long steps = 0;
  double seconds_before = 0.0;    // RankTraffic::own_seconds when it began
  std::vector<double> estimated;  // by rank, the costs of its steps
};

// Tests cannot wait for costs that differ. QUOIN_DEAR_BLOCKS=20x4: clocks say that each of the first 20 blocks costs
// four times as much as it is estimated to, and that dividing is free.
struct CostlyBlocks {
  int count = 0;
  double times = 1.0;
};

// Force on it through a stage: from what was to what shall be, over the ramp.
struct LoadRamp {
  Vec3 from{}, to{}, now{};  // N
};

// What does not change about the bodies of a group, by lane.
struct BodyGroupInertia {
  alignas(64) double weighing_mass[kLanes];       // kg, without scaling
  alignas(64) double inertia[6][kLanes];          // kg, kg m2
  alignas(64) double dt_over_inertia[6][kLanes];  // 0 where held, and in lanes without a body
};
BodyGroupInertia inertia_of(const BodyGroup& group, const Model& model, const Inertia& inertia, double time_step);

// Control of a block of any shape through a stage.
struct Drive {
  int block = -1;
  std::uint8_t held = 0;       // bits 0..2: velocity along x, y, z prescribed; 3..5: rotation
  std::uint8_t in_cycles = 0;  // bits 0..2: this component follows the cycles of the stage
  // bits 0..2: this component is of the ground, which adds its record to the velocities below: what is left of earlier
  // records.
  std::uint8_t of_ground = 0;
  std::int32_t motion = 0;  // that of the ground: 0; of a group of supports: from 1 on
  geometry::Vector velocity_from, velocity_to, omega_from, omega_to;  // m/s, rad/s
  geometry::Vector force_from, force_to, force_now;                   // N, along free components
};

// Of the joints of a rigid body, or a block, as a row of the history takes it.
struct JointWrench {
  Vec3 force{};             // N
  Vec3 moment{}, centre{};  // about its centre at the start, N m; where that is, m
  Vec3 displacement{};      // since the start, m
};

// One chunk's call of its law, with all columns in place; only the jumps differ by thread.
struct LawCall {
  quoin_batch batch{};
  std::vector<quoin_in> state_old;
  std::vector<quoin_out> state_new;
  std::vector<quoin_property_column> properties;  // that scatter
  double force_sum = 0.0;                         // of |force|, measured steps
  bool failed = false;
  quoin_status status = QUOIN_OK;
  double deepest = 0.0;  // smallest opening, m, measured steps
  int deepest_point = -1;
  long crushed_out = 0;                // contact points, steps that report flags
  double stored = 0.0;                 // J, energy steps
  std::array<double, 4> dissipated{};  // J during the last step, energy steps
  double damping = 0.0;                // J during the last step, by the damping of impacts
  Vec3 on_monitor{};                   // of the last row, on the deformable blocks of the monitor, N; with ranks
};

// Moves the body of lane 0 by a step: sums, control or free motion, gridpoints. Fixed order throughout.
void advance_body(const RigidBody& body, double mass, const Vec3& inertia, const StepData& step, BodyLanes* state,
                  Measured* measured);
// The same for the bodies of a group, side by side. Of the gridpoints it writes what the joints of their faces ask for:
// displacement along the normal, velocity across.
void advance_bodies(const Model& model, const BodyGroup& group, const BodyGroupInertia& inertia, const StepData& step,
                    BodyLanes* state, Measured* measured);

struct Simulation::Impl {
  Impl(Scene scene, Assembly assembly, int threads, std::vector<std::shared_ptr<const Material>> materials,
       const blocks::Assembly* shapes, Ranks* ranks);

  // --- the step -----------------------------------------------------------------------------------------------------
  // measure: sums for unbalanced force and energies; report: flags by contact point too.
  void step_once(bool measure, bool report);
  void begin_step(bool measure);
  void end_step(bool measure, bool report);
  // All chunks of contact points; then all items, which move blocks. clock: of the thread, started; null: not timed.
  using Work = std::function<void(int thread, int index, PhaseClock* clock)>;
  void each_chunk(const Work& work);
  void each_item(bool measure, const Work& work);
  PhaseClock* started_clock(int thread);
  void book_time(double wall, double weight);  // s, by what the clocks of the threads say; they begin again
  // Of the lattice.
  void advance_contacts(int thread, int chunk, bool measure, bool report, PhaseClock* clock);
  void advance_item(int thread, int item, bool measure);
  void apply_controls();
  void follow_ramps();
  void pull_whiffletree();
  // Along x, of the floor's bodies and blocks on average, m. As displacements are now; and at the time of the last
  // forces, a step before.
  double floor_displacement_now(std::size_t floor) const;
  double floor_displacement(std::size_t floor) const;
  double mean_along_x(const LoadedBlock& block, const LaneVector<double>& field) const;  // by the mass of gridpoints
  void apply_load(std::size_t loaded);  // what load_ramps has now, to the block's group
  void evaluate_law(int chunk, const ChunkJumps& jumps, bool measure, bool report);
  void damp_chunk(int chunk, const ChunkJumps& jumps);
  bool damps_impacts() const { return !old_jump.empty(); }  // on the lattice
  ImplicitContacts implicit_contacts;                       // of the lattice, where the stage has them
  std::vector<int> implicit_end;                            // of their pieces, per thread
  void weigh_chunk(int chunk, const ChunkJumps& jumps, const double* normal_way);
  void settle_contacts();
  [[noreturn]] void report_failed_points();
  std::string batch_text(const quoin_batch& batch) const;

  // --- stages -------------------------------------------------------------------------------------------------------
  void begin_stage(int index);
  void control_bodies(const Stage& settings, const Stage* previous);  // and find the monitor; null: none
  // motion: of the ground, where the body moves with it. left_over: velocity of the ground, m/s.
  void control_body(std::size_t body, const Stage& settings, const Stage* previous, std::int32_t motion,
                    const Vec3& left_over);
  void find_monitor(const Stage& settings);
  void find_loaded_blocks();
  // Sets velocities (else forces) of bodies, or blocks, that have this name: those components that are numbers.
  void steer_bodies(const char* what, const std::string& name, const std::vector<int>& bodies, const Vec3& value,
                    bool velocities);
  void steer_drives(const char* what, const std::string& name, const Vec3& value, bool velocities);
  void bind_whiffletree();  // bodies and blocks of the stage's floors
  void bind_controls();     // lists that follow from ramps and prescribed components
  void find_bodies_at_rest();
  void choose_damping();  // of the stage
  const SolverSettings& solver_in_use() const { return stage >= 0 ? scene.solver_in(at_stage()) : scene.solver; }
  std::size_t at_stage() const { return static_cast<std::size_t>(stage); }
  double added_kinetic_energy() const;  // of deformation and unit inertia, J
  void follow_solver();                 // inertia, time step and damping of the lattice, by the settings of the stage
  void begin_damping();                 // columns of the damping of impacts, where it is in use
  std::vector<LawSwap> swaps;           // of the current stage
  void swap_law(const std::string& family, const std::string& law);
  void swap_lattice_law(std::size_t family, std::shared_ptr<const Material> material);
  HistoryRow measure() const;
  void measure_monitor(HistoryRow& row) const;   // on the lattice
  double largest_displacement() const;           // of any block that is not fixed, m
  Vec3 point_traction(std::size_t point) const;  // with that of damping, Pa
  Vec3 sum_on_monitor(int chunk) const;          // of its points, on the deformable blocks of the monitor, N
  // Of the deformable blocks of the monitor, at the time of the last forces, m.
  Vec3 displacement_of_loaded(int loaded) const;
  void require_finite(const HistoryRow& row);  // throws Error(numerical)

  // --- what supports give (reactions.cpp) ---------------------------------------------------------------------------
  void find_restraints();
  void find_restrained_blocks();
  void measure_reactions(HistoryRow& row) const;
  JointWrench sum_joint_wrench(int body) const;
  std::vector<JointWrench> sum_large_motion_wrenches(const std::vector<int>& blocks) const;
  std::vector<std::uint8_t> held_now() const;  // by body, or by block

  // --- what holds blocks (supports.cpp) -----------------------------------------------------------------------------
  std::vector<std::uint8_t> held_in(const Stage& settings) const;  // by block; bits 0..2: x, y, z are imposed
  std::vector<int> groups_of_joined_blocks() const;                // by block: the first one of its group
  std::vector<int> loose_blocks(const Stage& settings) const;
  void require_moving_ground() const;  // Error(bad_input): a stage moves the ground, and no block is fixed
  void warn_of_loose_blocks(std::vector<Warning>* warnings);
  // Warns of a block that has left all supports. Throws Error(numerical) where the stage can only end at rest.
  void find_falling_block(std::vector<Warning>* warnings);
  std::string block_label(int block) const;

  // --- small displacements, and what ends them (small_motion.cpp) ----------------------------------------------------
  WholeMotion whole_motion_of(std::size_t brick) const;
  bool have_contact(int a, int b, int axis);  // two blocks that no joint joins, where they meet across this axis
  void check_motion();                        // and when to do so again: no output has a say in that
  std::string past_motion_bound() const;
  // After a step: goes over to large motion where blocks have moved too far, or warns, or throws Error(numerical).
  // Whether it has gone over.
  bool follow_motion(bool stage_ends, std::vector<Warning>* warnings);
  bool was_warned(const char* about) const;
  void warn_once(const char* about, const std::string& text, std::vector<Warning>* warnings);

  // --- the watch (watch.cpp) ----------------------------------------------------------------------------------------
  // Whether the energies of this step, before a row, are to be held against those of the next.
  bool begins_check() const;
  void end_check();
  void check_energies(const Energies& now, double dissipated, double work_before, double work_after);
  double allowed_overlap() const;
  void check_points();
  void check_stiffness();
  std::string damped_motion() const;  // what of it damping falsifies; all ranks ask together
  std::string motion_left_to_ground() const;
  std::optional<WrongAnswer> wrong_law() const;  // as the laws have answered last
  // When a row is written, after its step. Returns new warnings, which outcome has too.
  std::vector<Warning> look();

  Vec3 of_body(int body, BodyLanes::Quantity BodyLanes::*quantity) const;
  Vec3 joint_force(int body) const;  // of the contact points at the last law evaluation, N
  Vec3 sum_joint_force(int body) const;
  // Translation + rotation x arm of a rigid body at a reference position.
  Vec3 of_body_at(int body, BodyLanes::Quantity BodyLanes::*translation, BodyLanes::Quantity BodyLanes::*rotation,
                  const Vec3& position) const;
  // Opening and slips of a contact point at the time of its traction: displacements have moved on by one step since.
  Vec3 jump_at_traction(std::int32_t point) const;
  // Of the two gridpoints that a contact point joins, of block a and block b: their sum with these factors.
  std::pair<Vec3, Vec3> motion_of_sides(std::int32_t point, double of_displacement, double of_velocity) const;
  Vec3 jump_of(std::int32_t point, double of_displacement,
               double of_velocity) const;                // of their sum with these factors
  double opening_at_traction(std::int32_t point) const;  // as its law has it, with the shift of laws swapped in
  Vec3 mean_of(const std::vector<int>& indices, BodyLanes::Quantity BodyLanes::*quantity) const;  // over bodies
  double stage_fraction() const;  // by duration or displacement
  // Over the coming step, of what moved at this velocity when the cycles of the stage began, m/s. Its displacements add
  // up to the closed form.
  double velocity_in_cycles(double initial_velocity) const;
  bool force_lost();  // by the half cycle that has just ended, as the stage defines it
  bool equilibrium_reached(const Stage& settings);
  long chosen_record_interval() const;
  void sum_measurements();

  // --- blocks of any shape (large_motion_run.cpp)
  // -----------------------------------------------------------------------------
  void build_large_motion(const blocks::Assembly& shapes, std::vector<std::shared_ptr<const Material>> materials);
  void build_members();  // of the scene
  void exchange_nodes(std::vector<members::Node>& nodes) const;
  void find_blocks_on_base();
  void find_base_of_lattice();
  bool may_ride_in_parts(const blocks::Assembly& shapes) const;
  std::vector<int> rank_by_block() const;
  std::vector<int> followed_blocks() const;
  void exchange_blocks_of_stage(const Stage& settings, const Stage* previous);
  std::vector<int> blocks_named(const std::string& name, const std::string& where) const;
  void watch_blocks(const Stage& settings);                       // the monitor of the stage
  const std::string& watched_block(const Stage& settings) const;  // name of the stage's monitor; empty: none
  void begin_large_motion_stage(const Stage& settings, const Stage* previous);
  void swap_law_in_large_motion(std::size_t family, std::shared_ptr<const Material> material);
  void follow_time_step();  // of the large_motion model, which may have chosen a new one
  struct Action;            // step/actions
  std::vector<int> blocks_named_in(const Stage& settings) const;  // by its actions
  void bind_actions(const Stage& settings, const Stage* previous);
  void apply_actions(double ramp);
  void bind_drives(const Stage& settings, const Stage* previous);
  void bind_ground(const Stage& settings, const Stage* previous);
  void bind_forces(const Stage& settings, const Stage* previous);
  void bind_pressures(const Stage& settings, const Stage* previous);
  void bind_collapse(const Stage& settings, const Stage* previous);
  void drive_blocks(const Stage& settings, double ramp);
  void follow_ground(const Stage& settings, double ramp);
  void follow_ground_of_lattice(double ramp);
  const Drive* ground_drive() const;  // a block that moves as the ground does; null: none
  // By block, its group of supports as Drive::motion has it; 0: of none.
  std::vector<std::int32_t> support_groups(const Stage& settings) const;
  void scale_forces(const Stage& settings, double ramp);
  void scale_pressures(const Stage& settings, double ramp);
  void apply_gravity(const Stage& settings, double ramp);
  void apply_collapse(const Stage& settings, double ramp);
  void jack_members(const Stage& settings, double ramp);
  // Of the ground motion of a stage, m/s. motion: as in Drive.
  static constexpr double kGroundAtRest = 1e-12;  // m/s, rounding of a record that ends at rest
  geometry::Vector record_since_half_step(const Stage* of_stage, std::int32_t motion) const;  // m/s; null: none
  // On the lattice. left_over_velocity: velocity now of a body that moves with the ground, as the stage before has left
  // it, m/s. ground_body: a body that moves as the ground does, -1: none.
  Vec3 left_over_velocity(const Stage* previous, int body) const;
  int ground_body() const;
  geometry::Vector record_velocity(const Stage& of_stage, double time, std::int32_t motion = 0) const;
  void add_forces(const Stage& settings);
  void add_pressures(const Stage& settings);
  void pull_block(int block, double pull);
  bool stands_below(const std::vector<int>& blocks) const;
  bool collapse_ended(std::vector<Warning>* warnings);
  void watch_uplift();
  Vec3 block_translation(int block) const;                                 // of the centre of mass since the start, m
  Vec3 block_translation(const std::vector<int>& blocks) const;            // on average
  Vec3 block_translation_at_forces(const std::vector<int>& blocks) const;  // at the time of the forces of a row
  void measure_large_motion(HistoryRow& row) const;
  void measure_base(HistoryRow& row) const;
  void measure_base_on_lattice(HistoryRow& row) const;
  void check_rotations();
  BlockMesh mesh_in_large_motion(int block) const;
  BlockSize size_in_large_motion(int block) const;
  std::vector<Vec3> gridpoint_displacements(int block) const;  // of its gridpoints since the start, m
  std::vector<Vec3> gridpoint_velocities(int block) const;
  std::vector<std::array<double, 6>> zone_stresses(int block) const;  // by zone, Cauchy
  std::vector<ContactPoint> points_in_large_motion(const PointRange& range,
                                                   const std::function<bool(int block)>& wanted) const;
  std::vector<double> state_in_large_motion(const std::string& id, const PointRange& range) const;
  void each_point_in_large_motion(const std::function<void(std::int32_t point, int block_a)>& visit) const;
  std::vector<int> chunks_in_large_motion() const;
  void end_large_motion_step(double timed);  // how many steps this one's time stands for; 0: not timed
  void measure_large_motion_step();
  double stage_time() const;  // s, since the stage began
  double now() const;         // s, since the start

  // --- checkpoints (checkpoint.cpp) ---------------------------------------------------------------------------------
  void restore(ByteSource& source);  // throws half way
  std::shared_ptr<const Material> material_in_stage(std::size_t family, int of_stage) const;

  // --- from small displacements to large motion (promotion.cpp) -----------------------------------------------------
  void promote(const std::string& why);
  void leave_lattice();  // for large motion, at rest
  void return_to_lattice();
  std::optional<Assembly> left;  // by a promotion

  // --- one model on several processes (ranks.cpp); nothing is done without them -------------------------------------
  std::vector<double> estimated_costs() const;  // by item, its contact points included; any unit
  Vec3 place_in_large_motion(int block) const;  // all ranks find the same
  RankShare share_of_this_rank() const;         // in large motion once all has been gathered: positions count
  void bind_halo();  // what neighbours ask for in every step, and all ranks of what stages watch
  // Of gridpoints and bodies on borders: of those who move them to those who evaluate their contact points. Lattice.
  using SideNumbers = std::function<void(int block, std::int32_t gridpoint, std::vector<double*>&)>;
  Halo halo_on_borders(const SideNumbers& numbers_of);
  void receive_whole_borders();                // displacement and velocity, which steps exchange in part
  std::vector<int> ranks_of(int chunk) const;  // that evaluate it
  // Afterwards they have it as one process alone has it. next: of the shares that holders are to have; null: now.
  void gather(Part part, Who who = Who::everybody, const RankShare* next = nullptr);
  bool has_all() const;  // of the last step
  void begin_with_ranks();
  void agree_on_model() const;
  // An array whose parts ranks hold, some megabytes at a time, to rank 0.
  void give_array(const void* array, std::size_t bytes, const Simulation::TakeBytes& take);
  void end_run();     // what results ask rank 0 for
  void note_start();  // the hash, where no rank can compute it alone
  std::uint64_t hash_by_parts(bool at_rest);
  // How many contact points are in which state: of all, who has them; of chunks of this rank; of those of all ranks.
  std::array<long, kConditionCount> conditions_here() const;
  std::array<long, kConditionCount> own_conditions();
  std::array<long, kConditionCount> conditions_of_all();
  // Where each rank holds a part of the lattice (in_parts).
  struct Held {
    std::vector<bool> items, chunks;
  };
  Held held_with(const RankShare& shares) const;
  // Gridpoints, as numbers of arrays that have them, and contact points that this rank does not hold.
  struct Rows {
    std::vector<VectorRow> gridpoints, points;
  };
  Rows rows_elsewhere(const Held& held) const;
  // Of an array of a field with so many numbers, in order: visit(first, end). family: of its points; -1: of all.
  void each_row_elsewhere(const Rows& rows, Owner owner, int family, std::size_t numbers,
                          const std::function<void(std::size_t, std::size_t)>& visit) const;
  std::vector<int> own_units() const;  // in order
  void hold_part();                    // by share: gives back the memory of the rest
  void hold_first_part();              // and all agree on how stiff the stiffest joints are
  void hold_all();
  std::unique_ptr<SharedModel> share_of_model();
  void bind_inertia();  // of what is held
  void each_memory_of_item(Part part, int item, const VisitMemory& visit);
  void each_memory_of_chunk(Part part, int chunk, const VisitMemory& visit);
  void fetch_for_frame();      // what results by run, or pieces, show of the blocks of others; or all of it
  bool ranks_collect() const;  // to rank 0 what it writes of them
  void prepare_row();          // what a row has of the blocks of this rank
  // Whether any rank is in trouble: then all has been gathered, so that rank 0 sees what it is.
  bool agree(bool trouble, bool* deviates = nullptr, bool* leaves_frame = nullptr);
  double largest_of_ranks(double here) const;
  void send_motion();
  void receive_motion(bool measure_step);  // after the blocks have moved
  bool any_rank(bool here);                // needs it
  // All ranks throw what the first of them has found that has found anything.
  void throw_together(const std::optional<Error>& fault);
  void collect_traffic();
  void balance_ranks();  // between two steps: divides blocks again where that is worth it, by measured costs
  void repartition();
  double pretended_seconds() const;  // of costly_blocks, own work in the window, any unit
  // Sides of contact points: visit(item, key); numbers_of says where the motion that a key stands for lies.
  void each_side(int chunk, const std::function<void(int, std::int64_t)>& visit) const;
  void each_item(int chunk, const std::function<void(int)>& visit) const;  // side by side, of chunks of all ranks
  void numbers_of(std::int64_t key, std::vector<double*>& numbers);
  // Motion that every rank follows step by step: monitor, floors. visit(item, its numbers).
  void each_watched(const std::function<void(int, const std::vector<double*>&)>& visit);
  int item_of_block(int block) const;  // on the lattice
  std::vector<int> blocks_of_item(int item) const, bodies_of_item(int item) const;

  // --- set-up -------------------------------------------------------------------------------------------------------
  // The lattice of these bricks at rest, with its time step; none for an assembly of joint families alone.
  void take_bricks(Assembly assembly, const std::vector<std::shared_ptr<const Material>>& materials);
  void take_damage();  // of the scene: states and openings before the first stage
  void damage_large_motion(std::size_t family, const std::vector<CrackedBlock>& blocks, std::vector<double>& hit);
  void damage_lattice(std::size_t family, const std::vector<CrackedBlock>& blocks, std::vector<double>& hit);
  void bind_step();     // what a step reads, for the model of now
  void bind_columns();  // pointers of step data and law calls
  void bind_energies(LawCall& call, const ContactChunk& chunk);
  std::vector<int> chunks_here() const;  // that this process holds
  void begin_states();                   // of laws
  void share_inertia();                  // where the blocks of a group are congruent
  void divide_work();                    // costs, and the share of this rank
  void bind_work();                      // what follows from it
  void partition_work();                 // both, and holds its part
  std::vector<std::uint32_t> current_flags(const PointRange& range) const;
  // Fills the optional outputs of a batch with columns that begin at this contact point.
  using PointOutputs = std::function<void(quoin_batch&, std::size_t first_point)>;
  // A step that moves nothing, into scratch but for these outputs: of the points whose law has the capability.
  void ask_at_rest(std::uint64_t capability, const PointRange& range, const PointOutputs& outputs) const;
  void ask_large_motion_at_rest(std::uint64_t capability, const PointRange& range, const PointOutputs& outputs) const;
  std::size_t contact_point_count() const;
  PointRange all_points() const { return {0, static_cast<std::int32_t>(contact_point_count())}; }

  Scene scene;
  Model model;
  Inertia inertia;
  TimeStepReport time_step;
  ThreadPool pool;

  // State: everything that save() writes. Arrays by block, gridpoint and contact point: step/lattice_fields.h.
  LaneVector<double> displacement, velocity;
  LaneVector<double> traction[3];             // by contact point
  std::vector<LaneVector<double>> law_state;  // per family: state_count columns of its points one after the other
  LaneVector<double> normal_shift;            // by contact point: added to the opening (laws swapped in); else empty
  // Where impacts are damped, else empty: tractions of damping, Pa; opening of the last step, m, not a number: unknown.
  LaneVector<double> viscous[3], old_jump;
  std::vector<BodyLanes> body_lanes;  // body groups, then lone bodies
  std::vector<BodyRamp> ramps;
  std::vector<LoadRamp> load_ramps;  // by loaded block
  Vec3 gravity_from{}, gravity_to{};
  long step_count = 0;
  double clock_start = 0.0;   // s, of the lattice: when its time step was chosen last
  long clock_start_step = 0;  // and at which step
  int stage = -1;
  long stage_step = 0;
  Vec3 monitor_start{};
  std::array<double, 4> energy_dissipated{};
  double energy_damping = 0.0, energy_external = 0.0;  // up to the last half step
  double energy_inertia = 0.0;                         // lost with added inertia where stages take less of it
  int calm_checks = 0;                                 // equilibrium checks passed in a row
  int next_frame = 0;
  long next_row = 0;      // stage_step of the next history row
  long row_interval = 1;  // of the stage; found at its start, as the step may change later
  bool in_stage = false;
  MotionSeen motion_seen;
  long next_motion_check = 0;  // step
  Watch watch;
  ForceLoss force_loss;  // in cycles

  // Blocks of any shape in large motion; null: none.
  std::unique_ptr<blocks::Model> large_motion;
  std::vector<std::uint8_t> on_base;  // by block: a free one that rests on fixed ones at the start
  geometry::Vector base_centre;       // of the area between these at the start, m
  std::vector<Drive> drives;
  std::size_t fading_loads = 0, fading_pressures = 0;  // the first of the model's, from the stage before
  double stage_start_time = 0.0;                       // s
  double multiplier = 0.0;                             // of the body force of a collapse stage
  FirstLoad first_load;
  std::vector<int> monitor_blocks;
  bool monitor_stands_below = false;  // at the start of the stage: what these blocks touch is above them
  Outcome outcome;

  // Rebuilt from the state or derived.
  std::vector<std::shared_ptr<const Material>> first_materials;  // by joint family, before any law is swapped
  LaneVector<double> dt_over_mass;
  std::set<std::vector<double>> inertia_tables;  // of groups whose blocks share them
  std::vector<const double*> shared_dt_over_mass;
  std::vector<std::pair<int, int>> body_place;  // by body: index into body_lanes, lane
  std::vector<int> ramped_bodies;               // whose control changes over the ramp
  std::vector<BodyGroupInertia> group_inertia;  // by body group
  LaneVector<double> force[3];                  // by contact point, and a dummy
  LaneVector<double> energy_columns[5];  // stored, dissipated by mode; scratch by contact point, energy runs only
  LaneVector<std::uint32_t> flags;
  long flags_step = -1;  // step that computed them
  std::vector<LawCall> calls;
  std::vector<Measured> measured;  // by item
  double unbalanced_ratio = 0.0;
  std::optional<Energies> energies;
  double kinetic = 0.0;
  std::vector<int> monitor;         // bodies that the history shows
  std::vector<int> monitor_loaded;  // and deformable blocks, indices into loaded_blocks
  struct MonitorPoint {
    std::int32_t point;
    double sign;  // 1: side a
  };
  std::vector<MonitorPoint> monitor_points;  // of these blocks, in order
  std::vector<Restraint> restraints;
  bool restraints_found = false;
  std::vector<int> restrained_blocks;  // in large motion: fixed, or held by some stage
  std::vector<int> restraint_of;       // by body, or by block: index into restraints; -1: none
  JointSliding joint_sliding;
  UnjoinedBlocks unjoined;
  std::vector<std::uint8_t> held_blocks;                      // held_in of the stage
  double extent = 0.0;                                        // diagonal of the model at the start, m
  std::function<int(const blocks::Meeting&)> meeting_family;  // of blocks that meet; empty: not asked yet
  std::vector<WholeMotion> whole_motions;                     // by brick
  struct Floor {
    std::vector<int> bodies, loaded;  // loaded: indices into loaded_blocks
    std::vector<int> large_motion;    // blocks in large motion, in place of both
    double count() const { return static_cast<double>(bodies.size() + loaded.size() + large_motion.size()); }
  };
  std::vector<Floor> whiffletree;            // in stages that have one
  std::vector<LoadedBlock> loaded_blocks;    // deformable blocks that have a name
  LaneVector<double> load;                   // of groups with loaded blocks: [component][lane], m/s2
  std::vector<const double*> load_of_group;  // by group, into load; null: none
  std::optional<CyclicMotion> cycles;        // of the stage
  bool controls_settled = true;              // the ramp of the stage is over, and no body moves in cycles
  bool rest_known = true;                    // at_rest of all bodies is up to date
  bool want_energy = false;
  // By what every step measures; blocks that ride add theirs up themselves.
  bool books_energy() const { return want_energy && !large_motion; }
  bool sample_energy = false;  // of this step alone, for the watch
  bool keep_diagnostics = false;

  StepData data;
  RankShare share;                // items: unit groups, body groups, lone bodies; or pieces of blocks of any shape
  std::size_t largest_group = 0;  // of deformable blocks, doubles
  std::vector<int> chunk_end, border_end, item_end;  // per thread, into those lists
  std::vector<double> item_cost, chunk_cost;         // of all; of an item without its contact points
  std::vector<LaneVector<double>> scratch;           // per thread
  std::vector<std::unique_ptr<ChunkJumps>> jumps;
  std::atomic<bool> law_failed{false};

  Ranks* ranks = nullptr;          // null: one process alone
  Halo halo;                       // of this rank
  bool in_parts = false;           // each rank holds a part of the model
  bool ranks_failed = false;       // one of them in this step
  bool has_row = false;            // what a row takes, in large motion in parts, of the last step
  bool holds_all = true;           // this one all of it
  std::vector<int> unit_of_group;  // by block group: its item
  std::vector<int> item_by_block;  // with ranks
  Clock::time_point run_start = Clock::now();
  std::vector<JointWrench> body_wrench;              // of joints, by body, of the last row; with ranks
  std::vector<std::vector<int>> restrained_of_item;  // with ranks, in large motion: restrained_blocks, by item
  std::vector<JointWrench> block_wrench;             // of these, by block, of the last row; with ranks
  bool gathered = true, gathered_by_first = true;    // all of it, since the last step: by everybody, by rank 0
  bool stop_wanted = false, stop_agreed = false;     // here; by any rank
  RankTraffic traffic;                               // of this rank
  RankBalance balance;
  RankWindow window;
  std::vector<double> measured_over_estimated;  // cost by block; empty: nothing is known yet
  std::optional<CostlyBlocks> costly_blocks;    // for tests
  std::vector<RankTraffic> traffic_of_all;
  bool together = true;  // all ranks end in the same way
  // Of the end of a run in parts, for rank 0.
  std::optional<std::array<long, kConditionCount>> end_conditions;
  std::uint64_t end_hash = 0;
  std::optional<std::uint64_t> start_hash;  // of a run in parts whose states differ from rank to rank at the start

  bool time_every_step = false;
  double timed_steps = 0.0;  // that this one's time stands for; 0: it is not timed
  PhaseTimes times;
  std::vector<PhaseClock> clocks;  // by thread
};

}  // namespace quoin
