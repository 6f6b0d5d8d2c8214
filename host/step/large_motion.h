// Blocks of any shape in large motion: their explicit step in time.
//
// - Rigid blocks: central differences for translation. For rotation the unknown is the angular momentum, and the
//   orientation follows by the implicit midpoint rule. So a free block conserves its angular momentum to rounding, and
//   its energy does not drift.
// - Deformable blocks: linear elasticity at small strain, exactly indifferent to rotation. Internal forces come from a
//   stiffness in the co-rotational frame (deformable_kernels.h), which congruent blocks share. For blocks that deform
//   much they are total Lagrangian, zone by zone (zone_kernels.h).
#pragma once

#include <optional>

#include "base/phase_clock.h"
#include "law/answers.h"
#include "model/impact_damping.h"
#include "model/world.h"
#include "step/rank_share.h"

namespace quoin {
struct ArchiveReader;
}  // namespace quoin

namespace quoin::blocks {

struct Model : World {
  using World::World;

  // An answer of a law in the last step that breaks the contract, with place and points; nothing: there is none.
  std::optional<WrongAnswer> wrong_law(std::span<const int> own_chunks) const;
  std::string batch_text(const quoin_batch& batch) const;  // as that of findings.h
  // Parts of a step of length stepping.dt: begin, all chunks, all pieces, end. Then find_contacts, where end_step()
  // returns that blocks have moved enough. Chunks are independent of each other, pieces too, and sums have a fixed
  // order: results are bitwise identical for any number of threads. clock: of the thread, started; null: not timed.
  // measure: the step measures energies. end_step throws Error(numerical): the law failed at a point, or the position
  // of a block is not finite.
  void begin_step(bool measure = false);
  void advance_contacts(int chunk, PhaseClock* clock = nullptr);
  void advance_piece(int piece, PhaseClock* clock = nullptr);
  bool end_step();
  // Viscosity of joints and zones by impact damping.
  ImpactDamping impact_damping() const;
  void find_contacts();

  // From all data that change during a run (saved_state.h), in families with the laws of the saved state. Throws
  // Error(bad_input) when the bytes are of another model, and leaves this one unusable. A restored run is bitwise
  // identical for any number of threads.
  void restore(ArchiveReader& reader);

  // For several processes, each of which advances some chunks and pieces (large_motion_ranks.cpp).
  // Whether a law has failed at a point of these chunks, or a block of these pieces has no finite position.
  bool in_trouble(std::span<const int> own_chunks, std::span<const int> own_pieces) const;
  // Whether some block of these pieces has deformed too much for its frame.
  bool leaves_frame(std::span<const int> own_pieces) const;
  // Whether some block of these pieces has moved enough for contact detection to be due.
  bool has_deviating(std::span<const int> own_pieces) const;
  // Computes the numbers of a history row over these chunks and pieces.
  void scan_for_row(std::span<const int> own_chunks, std::span<const int> own_pieces);
  void each_memory_of_piece(Part wanted, int piece, const VisitMemory& visit);
  void each_memory_of_chunk(Part wanted, int chunk, const VisitMemory& visit);
  // Visits each side of the chunk's contact points: its block, and the key of the body or gridpoint whose motion the
  // point reads.
  void each_side(int chunk, const std::function<void(int block, std::int64_t key)>& visit) const;
  // Appends addresses of the numbers that give the position of `key`.
  void numbers_of(std::int64_t key, std::vector<double*>& numbers);
  void motion_of(int block, std::vector<double*>& numbers);  // the same for position and velocity of a whole block

  bool measured = false;          // whether this step measures energies
  bool copies_velocities = true;  // whether this step copies velocities in lanes to Gridpoints
  bool velocities_lent = false;   // whether a user may write those in Gridpoints, before any step
  double measured_kinetic = 0.0;  // kinetic energy at the time of the forces of the last measured step, J
};

// Loads of the stage in the last step, without weight. load_on: their sum, N. each_load_on_gridpoints: those of points
// and pressures, and of the moment in Actions::applied; not its force, which is distributed by mass.
Vector load_on(const Model& m, int block);
Wrench loads_on_body(const Model& m, int block);
using VisitLoad = std::function<void(int32_t node, const Vector& force)>;
void each_load_on_gridpoints(const Model& m, int block, const VisitLoad& visit);
bool has_deformed_too_much(const Model& m, int block);  // for its frame, in the last step

}  // namespace quoin::blocks
