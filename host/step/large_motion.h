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

struct Model : World {
  using World::World;

  // One explicit step of length time_step(): the phases of the method. Their pieces are independent of each other, and
  // sums are taken in a fixed order: the bits do not depend on the number of threads. Throws Error(numerical): the law
  // failed at a point, or the position of a block is no longer a finite number.
  void step();
  // What a law has answered last that it must not, where and for which points; nothing: all is well.
  std::optional<WrongAnswer> wrong_law(std::span<const int> own_chunks) const;
  std::string batch_text(const quoin_batch& batch) const;  // text as Simulation's
  // Threads for the steps from now on; null: the caller alone. The pool must outlive them.
  void use(ThreadPool* threads) { pool = threads, shared_division = -1; }
  // The same piece by piece, for a host that has more to do in a step: begin, all chunks, all pieces, end. Then
  // find_contacts, when end_step() says that blocks have moved enough. clock: of the thread, started; null: not timed.
  // measure: the energies of the step are requested.
  void begin_step(bool measure = false);
  void advance_contacts(int chunk, PhaseClock* clock = nullptr);
  void advance_piece(int piece, PhaseClock* clock = nullptr);
  bool end_step();
  // What it does to joints and zones.
  ImpactDamping impact_damping() const;
  void mark_deviation() { checks.any_deviates = true; }  // for a block of another process
  void find_contacts();
  void run(double duration);  // s

  // Everything that changes during a run. The families must have the laws that they had at the time. restore() throws
  // Error(bad_input) when the bytes come from another model, which then is in no state to go on from. Bits after it are
  // those of an uninterrupted run, whatever the number of threads. give takes the bytes of long arrays, in their order,
  // in place of the writer; empty: the writer has all.
  using GiveArray = std::function<void(ArchiveWriter& writer, const void* first, size_t bytes)>;
  void save(ArchiveWriter& writer, const GiveArray& give = {});
  void restore(ArchiveReader& reader);

  // For several processes, each of which advances some chunks and pieces (large_motion_ranks.cpp).
  // Whether something of theirs is wrong: a law that has failed, a block that is nowhere.
  bool in_trouble(std::span<const int> own_chunks, std::span<const int> own_pieces) const;
  bool leaves_frame(std::span<const int> own_pieces) const;  // some block of theirs, which has deformed too much for it
  bool has_deviating(
      std::span<const int> own_pieces) const;  // some block of theirs: contacts may have to be found again
  // Numbers of a row of the history, over these blocks and points.
  void scan_for_row(std::span<const int> own_chunks, std::span<const int> own_pieces);
  void each_memory_of_piece(Part wanted, int piece, const VisitMemory& visit);
  void each_memory_of_chunk(Part wanted, int chunk, const VisitMemory& visit);
  // Visits each side of a contact point: its block, and the body or gridpoint whose motion the point reads.
  void each_side(int chunk, const std::function<void(int block, std::int64_t key)>& visit) const;
  void numbers_of(std::int64_t key, std::vector<double*>& numbers);  // that say where it is
  void motion_of(int block, std::vector<double*>& numbers);          // place and velocity of a whole block

  bool measured = false;          // this step
  double measured_kinetic = 0.0;  // energy at the time of the forces of the last step, which was measured, J
  ThreadPool* pool = nullptr;
  std::vector<int> chunk_end, piece_end;  // shares of the threads
  long shared_division = -1;              // that they are of
};

bool has_deformed_too_much(const Model& m, int block);  // for its frame, in the last step

}  // namespace quoin::blocks
