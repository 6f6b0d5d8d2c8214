// Pieces: blocks that one task advances together, and the columns that kernels read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/block_inertia.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

inline constexpr int kBodies = 8;  // blocks of a SIMD group
// Least number of congruent blocks for which one product with their shared stiffness is faster than one product each.
inline constexpr size_t kFewestCongruent = 3;

// Rows of Chunks::rows, one a block of a group in frames; for blocks without one the last row.
using RowLine = std::array<uint32_t, size_t(kBodies)>;

// Contact points on gridpoint `node` of each block of a group in frames; one point a block.
struct GridpointLine {
  int32_t node;
  bool side_a;  // whether the blocks are a's of the points, on which the force acts; else its opposite does
  RowLine row;  // of the force
};

// Blocks of a group in fixed frames, at the start. rotation: R of their frames.
struct FixedFrameLanes {
  InertiaLanes inertia;
  ByLane rotation[3][3];
};

// Blocks that are advanced together: rigid blocks, deformable single blocks, or all first halves and then all second
// halves of units.
struct Piece {
  uint32_t first, count;  // indices into Pieces::blocks; a group has at most kBodies
  bool halves;            // whether it has two groups, which hold the first and second halves of units lane by lane
  bool apart;             // whether its blocks are halves that are apart
  enum class Kind : uint8_t { rigid, congruent, distinct, by_zone } kind;
  int32_t congruent[2] = {-1, -1};  // of its groups: index into Zones::congruent, for congruent blocks
  static constexpr size_t kNoColumns = size_t(-1);
  size_t columns[2] = {kNoColumns, kNoColumns};  // first number of the FixedColumns of its groups in Pieces::columns
  bool some_held = false;
  bool fixed = false;                          // whether the frames of its blocks are fixed; of congruent blocks
  std::vector<FixedFrameLanes> at_start = {};  // of its groups in fixed frames
  bool other_sides = true;                     // whether blocks have sides of contact points beside those of `lines`
  // Of its groups, in frames: contact points on gridpoints, and moments on the frames.
  std::vector<GridpointLine> lines[2] = {};
  std::vector<RowLine> moments[2] = {};
  size_t motion[2] =
      {};  // of congruent blocks: first number of its groups' positions, then velocities, in Pieces::motion
  size_t group_count() const { return halves ? 2 : 1; }
  bool in_frame() const { return kind == Kind::congruent || kind == Kind::distinct; }
};

// Columns that steps seldom change, of the gridpoints of up to kLanes deformable blocks, side by side. A line holds one
// gridpoint of each block: three numbers a lane for vectors, one for scalars. Gridpoints that a block lacks have no
// mass and the position of its first gridpoint. Lanes without a block repeat the last one.
template <class Number>
struct FixedColumns {
  Number *mass, *over_mass;  // mass for inertia, kg; its inverse, 1/kg, or 0
  Number *place, *anchor;    // of distinct blocks: X from the first gridpoint, m, and b, 1/m; else null
  Number* held_v;            // velocities of supports, m/s, NaN where free; null: no gridpoint is held
  Number* arm;               // of blocks in fixed frames: reference position from the mass centre, m; else null
  FixedColumns(Number* from, int node_count, const Piece& piece) {
    const auto take = [&](bool wanted, int numbers) {
      Number* const column = wanted ? from : nullptr;
      if (wanted) from += size_t(node_count) * size_t(numbers);
      return column;
    };
    const bool distinct = piece.kind == Piece::Kind::distinct;
    mass = take(true, kLanes), over_mass = take(true, kLanes);
    place = take(distinct, kLine), anchor = take(distinct, kLine);
    held_v = take(piece.some_held, kLine);
    arm = take(piece.fixed, kLine);
  }
  static size_t size(int node_count, const Piece& piece) {
    const int distinct = piece.kind == Piece::Kind::distinct ? 2 * kLine : 0;
    const int held = piece.some_held ? kLine : 0, arms = piece.fixed ? kLine : 0;
    return size_t(node_count) * size_t(2 * kLanes + distinct + held + arms);
  }
};

// Blocks are divided again when some leave their frames, and when halves come apart or join. Lines follow the contacts,
// and columns the supports.
struct Pieces {
  bool are_old = true;  // whether blocks must be divided again
  std::vector<Piece> all;
  std::vector<int32_t> blocks;    // piece after piece
  std::vector<int32_t> of_block;  // piece of each own deformable block; -1: blocks of other ranks
  std::vector<uint8_t> in_frame;  // by block: 1 if its piece is advanced in frames
  LaneVector<double> columns;     // FixedColumns of groups
  // Positions, m, and velocities, m/s, of groups of congruent blocks, in lanes. Steps change them, and copy positions
  // to Gridpoints in each step, velocities where something reads them there (copy_velocities).
  LaneVector<double> motion;
  bool motion_is_old = true;  // whether gridpoints have moved, or their velocities changed, outside of steps since then
  std::vector<std::int64_t> lane_of_block;  // by block: number of its first x in `motion`; -1: it is not there
  bool velocities_lag = false;              // whether steps have changed velocities in lanes alone
  // By piece: whether end_step must check its blocks, as the last step has found something unusual. Of own pieces.
  std::vector<uint8_t> needs_check;
  std::vector<size_t> shared_columns;  // columns of groups, by kind of congruent blocks, frames and supports
  std::vector<int> held_changed;       // deformable blocks whose supports changed since the last step
  bool any_held_changed = false;       // whether supports of any gridpoint have changed

  std::span<const int32_t> blocks_of(int piece) const { return blocks_of(all[size_t(piece)]); }
  std::span<const int32_t> blocks_of(const Piece& piece) const {
    return std::span(blocks).subspan(piece.first, piece.count);
  }
  std::span<const int32_t> blocks_of(const Piece& piece, size_t group) const {
    const size_t count = piece.count / piece.group_count();
    return blocks_of(piece).subspan(group * count, count);
  }
};

int count_of(const World& w, Piece::Kind kind);  // number of blocks in pieces of a kind
double piece_work(const World& w, int piece);
void divide_blocks(World& w);
void bind_pieces(World& w);  // binds pieces to their columns and contact points
void follow_held(World& w);  // updates supports in the columns, before a step
// Copies velocities of congruent blocks from lanes to Gridpoints, which steps do only where they measure or check
// motion. By one thread.
void copy_velocities(World& w);
int most_gridpoints(const World& w, std::span<const int32_t> blocks);  // largest number of gridpoints of a block

}  // namespace quoin::blocks
