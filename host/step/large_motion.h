// Blocks of any shape that move on in time, without bound.
//
// - Rigid blocks: central differences in translation. In rotation the angular momentum is the unknown and the
//   orientation follows by the implicit midpoint rule. So a free block keeps its angular momentum to rounding and its
//   energy without drift.
// - Deformable blocks: linear elasticity at small strain, exactly indifferent to rotation. By a stiffness in their own
//   frame (deformable_kernels.h), which congruent blocks share; those that deform much zone by zone, total Lagrangian
//   (zone_kernels.h).
#pragma once

#include <optional>

#include "base/phase_clock.h"
#include "base/thread_pool.h"
#include "law/answers.h"
#include "model/impact_damping.h"
#include "model/world.h"
#include "step/rank_share.h"

namespace quoin {
struct ArchiveWriter;
struct ArchiveReader;
}  // namespace quoin

namespace quoin::blocks {

struct LaneColumns;
struct RigidGains;

class Model : public World {
 public:
  using World::World;

  // One explicit step of length time_step(): the phases of the method. Their pieces are independent of each other, and
  // sums are taken in a fixed order: the bits do not depend on the number of threads. Throws Error(numerical): the law
  // failed at a point, or the position of a block is no longer a finite number.
  void step();
  // What a law has answered last that it must not, where and for which points; nothing: all is well.
  std::optional<WrongAnswer> wrong_law(std::span<const int> chunks) const;
  std::string batch_text(const quoin_batch& batch) const;  // as Simulation's
  // Threads for the steps from now on; null: the caller alone. The pool must outlive them.
  void use(ThreadPool* pool) { pool_ = pool, shared_division_ = -1; }
  // The same piece by piece, for a host that has more to do in a step: begin, all chunks, all pieces, end. Then
  // find_contacts, when end_step() says that blocks have moved enough. clock: of the thread, started; null: not timed.
  // measured: the energies of the step are asked for.
  void begin_step(bool measured = false) {
    measured_ = measured || energy_;
    follow_held();
    if (frames_.are_old) find_block_frames();
    if (held_by_.members) follow_members();
  }
  void advance_contacts(int chunk, PhaseClock* clock = nullptr);
  void advance_piece(int piece, PhaseClock* clock = nullptr);
  bool end_step();
  // What it does to joints and zones.
  ImpactDamping impact_damping() const {
    ImpactDamping damping;
    for (std::size_t f = 0; 2 * f < impacts_.beta.size(); ++f)
      damping.viscosity.push_back({impacts_.beta[2 * f], impacts_.beta[2 * f + 1]});
    damping.of_zones = impacts_.zone_beta, damping.in_use = impact_damping_in_use();
    return damping;
  }
  // At the time of the forces of the last step, which was measured, J.
  double measured_kinetic_energy() const { return measured_kinetic_; }
  void mark_deviation() { checks_.any_deviates = true; }  // for a block of another process
  void find_contacts();
  void run(double duration);  // s
  void run_steps(long steps) {
    for (long i = 0; i < steps; ++i) step();
  }

  // Everything that changes during a run. The families must have the laws that they had at the time. restore() throws
  // Error(bad_input) when the bytes come from another model, which then is in no state to go on from. Bits after it are
  // those of an uninterrupted run, whatever the number of threads. give takes the bytes of long arrays, in their order,
  // in place of the writer; empty: the writer has all.
  using GiveArray = std::function<void(ArchiveWriter& writer, const void* first, size_t bytes)>;
  void save(ArchiveWriter& writer, const GiveArray& give = {});
  void restore(ArchiveReader& reader);

  // For several processes, each of which advances some chunks and pieces (large_motion_ranks.cpp).
  // Whether something of theirs is wrong: a law that has failed, a block that is nowhere.
  bool in_trouble(std::span<const int> chunks, std::span<const int> pieces) const;
  bool leaves_frame(std::span<const int> pieces) const;   // some block of theirs, which has deformed too much for it
  bool has_deviating(std::span<const int> pieces) const;  // some block of theirs: contacts may have to be found again
  // For rows of the history: what is asked of all blocks and points, found for these.
  void scan_for_row(std::span<const int> chunks, std::span<const int> pieces);
  void each_memory_of_piece(Part part, int piece, const VisitMemory& visit);
  void each_memory_of_chunk(Part part, int chunk, const VisitMemory& visit);
  // Of each side of a contact point: its block, and the body or gridpoint whose motion the point reads.
  void each_side(int chunk, const std::function<void(int block, std::int64_t key)>& visit) const;
  void numbers_of(std::int64_t key, std::vector<double*>& numbers);  // that say where it is
  void motion_of(int block, std::vector<double*>& numbers);          // place and velocity of a whole block

 private:
  bool has_deformed_too_much(int block) const;
  // phases of the step: contacts chunk by chunk, then blocks piece by piece
  struct Axes {  // of the points of a chunk
    FacetFrames* triangles;
    PairAxes* pairs;
  };
  void contact_kinematics(Family& f, Chunk& chunk, const Axes& axes);
  void contact_law(Family& f, Chunk& chunk);
  void contact_forces(Family& f, Chunk& chunk, const Axes& axes);
  void viscous_tractions(Family& f, Chunk& chunk);
  void advance_deformable(const Piece& piece, PhaseClock* clock);
  struct LaneGroup;
  void find_forces(const Piece& piece, size_t group_index, LaneGroup& group, LaneColumns& columns, PhaseClock* clock);
  // force: four doubles a gridpoint of the block, set. Returned: what is shared by mass, m/s2 of the mass of inertia.
  // zone_forces_of adds to the forces, and to their viscous part where that is not null.
  Vector forces_on_gridpoints(int block, double* force);
  void zone_forces_of(const ModelBlock& b, BlockSums& sums, double* force, double* viscous);
  void forces_on_body(int block);
  struct Wrench {
    Vector force, torque;  // N; about the centre of mass, N m
  };
  Wrench loads_on_body(int block) const;
  void advance_bodies(std::span<const int32_t> blocks, PhaseClock* clock);
  // Inertia scaled apart, damping by block (block_inertia.h): what gridpoints of each block gain.
  void split(const Piece& piece, std::span<const LaneColumns> columns, RigidGains* gains);
  // visit(gridpoint, force of a load or pressure on it, N), where gridpoints were `since` seconds ago.
  template <class Visit>
  void each_load_on_gridpoints(int block, double since, const Visit& visit) const;
  // Of these with the velocities of now, W. The work of a step is that of its forces with the mean of the velocities
  // before and after it, as of all other forces.
  double power_on_gridpoints(int block, double since) const;
  void sum_up();
  void sum_up_members();
  template <class Visit>
  void each_member_force(int block, const Visit& visit) const;  // visit(node)
  void leave_frames();                                          // blocks that have deformed too much for theirs
  void watch() const;  // throws Error(numerical): a block that is nowhere, with its name, its place of the start, step
  [[noreturn]] void report_failure(const Chunk& chunk) const;
  double zone_damping() const;
  void share_work();

  template <class Archive, class Self>
  static void transfer_state(Archive& archive, Self& m);

  bool measured_ = false;  // this step
  double measured_kinetic_ = 0.0;
  ThreadPool* pool_ = nullptr;
  std::vector<int> chunk_end_, piece_end_;  // shares of the threads
  long shared_division_ = -1;               // that they are of
};

}  // namespace quoin::blocks
