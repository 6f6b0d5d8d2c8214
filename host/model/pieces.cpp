#include "model/pieces.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <utility>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Positions of the gridpoints of a congruent block at the start, from its mass centre. From the shared shape, so that
// blocks of one orientation have the same bits.
std::vector<Vector> arms_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const std::vector<Vector>& place = w.zones.congruent[size_t(b.congruent)].place;
  const double* const mass = w.nodes.mass.data() + b.first_node;
  const Matrix r = start_of_frame(w, block);
  double sum = 0.0;
  Vector centre;
  for (size_t n = 0; n < place.size(); ++n) sum += mass[n], centre += mass[n] * place[n];
  centre = centre / sum;
  std::vector<Vector> arms;
  for (const Vector& x : place) arms.push_back(r * (x - centre));
  return arms;
}

// arm: line of a group's columns. held: by the supports of now.
FixedFrameLanes lanes_at_start(const World& w, std::span<const int32_t> blocks, const double* arm) {
  FixedFrameLanes at_start;
  InertiaLanes& lanes = at_start.inertia;
  for (size_t l = 0; l < size_t(kLanes); ++l) {
    const int32_t block = blocks[std::min(l, blocks.size() - 1)];
    const ModelBlock& b = w.blocks[size_t(block)];
    const Matrix r = start_of_frame(w, block);
    const auto arm_of = [&](size_t n) {
      const double* const x = arm + n * kLine + l;
      return Vector{x[0], x[kLanes], x[2 * kLanes]};
    };
    const auto first = size_t(b.first_node);
    const Vector centre = w.nodes.reference[first] - arm_of(0);
    double mass = 0.0;
    Matrix second = Matrix::zero();
    uint8_t held = 0;
    for (size_t n = 0; n < size_t(b.node_count); ++n) {
      mass += w.nodes.mass[first + n], held |= w.nodes.held[first + n];
      second += w.nodes.mass[first + n] * outer(arm_of(n), arm_of(n));
    }
    lanes.mass.of[l] = mass;
    for (int i = 0; i < 3; ++i) {
      lanes.centre[i].of[l] = centre[i], lanes.held[i].of[l] = held >> i & 1;
      for (int j = 0; j < 3; ++j)
        lanes.second[i][j].of[l] = second.row[i][j], at_start.rotation[i][j].of[l] = r.row[i][j];
    }
  }
  return at_start;
}

void fill_columns(const World& w, std::span<const int32_t> blocks, const FixedColumns<double>& to) {
  if (to.held_v) std::fill_n(to.held_v, most_gridpoints(w, blocks) * kLine, std::nan(""));
  for (size_t l = 0; l < size_t(kLanes); ++l) {
    const int32_t block = blocks[std::min(l, blocks.size() - 1)];
    const ModelBlock& b = w.blocks[size_t(block)];
    for (size_t n = 0; n < size_t(b.node_count); ++n) {
      const size_t node = size_t(b.first_node) + n;
      to.mass[n * kLanes + l] = w.nodes.mass[node], to.over_mass[n * kLanes + l] = 1.0 / w.nodes.mass[node];
      const Vector place = w.nodes.reference[node] - w.nodes.reference[size_t(b.first_node)];
      for (int c = 0; c < 3; ++c) {
        const size_t at = n * kLine + size_t(c) * kLanes + l;
        if (to.place) to.place[at] = place[c], to.anchor[at] = w.nodes.anchor[node][c];
        if (w.nodes.held[node] >> c & 1) to.held_v[at] = w.nodes.held_v[node][c];
      }
    }
    if (!to.arm) continue;
    const std::vector<Vector> arms = arms_of(w, block);
    for (size_t i = 0; i < arms.size() * 3; ++i) to.arm[i / 3 * kLine + i % 3 * kLanes + l] = arms[i / 3][int(i % 3)];
  }
}

// Groups of congruent blocks whose columns agree to the last bit share them. Shapes that are congruent only to rounding
// have other masses.
void fill_columns(World& w, Piece& piece) {
  const std::span<const int32_t> all = w.pieces.blocks_of(piece);
  const bool some_held = std::any_of(all.begin(), all.end(), [&](int32_t block) {
    const ModelBlock& b = w.blocks[size_t(block)];
    const auto held = std::span(w.nodes.held).subspan(size_t(b.first_node), size_t(b.node_count));
    return std::any_of(held.begin(), held.end(), [](uint8_t bits) { return bits != 0; });
  });
  const bool held_as_before = some_held == std::exchange(piece.some_held, some_held);
  piece.at_start.clear();
  thread_local LaneVector<double> numbers;
  for (size_t group = 0; group < piece.group_count(); ++group) {
    const int most = most_gridpoints(w, w.pieces.blocks_of(piece, group));
    numbers.assign(FixedColumns<double>::size(most, piece), 0.0);
    const FixedColumns<double> to(numbers.data(), most, piece);
    fill_columns(w, w.pieces.blocks_of(piece, group), to);
    if (to.arm) piece.at_start.push_back(lanes_at_start(w, w.pieces.blocks_of(piece, group), to.arm));
    size_t& columns = piece.columns[group];
    size_t* const shared =
        piece.kind == Piece::Kind::congruent
            ? &w.pieces.shared_columns[4 * size_t(piece.congruent[group]) + 2 * piece.fixed + some_held]
            : nullptr;
    const auto agree = [&](size_t at) {
      return at != Piece::kNoColumns &&
             std::memcmp(w.pieces.columns.data() + at, numbers.data(), numbers.size() * sizeof(double)) == 0;
    };
    if (shared && agree(*shared)) {
      columns = *shared;
      continue;
    }
    const bool stays = columns != Piece::kNoColumns && held_as_before && !(shared && columns == *shared);
    if (!stays) columns = w.pieces.columns.size(), w.pieces.columns.resize(columns + numbers.size());
    std::copy(numbers.begin(), numbers.end(), w.pieces.columns.begin() + std::ptrdiff_t(columns));
    if (shared && *shared == Piece::kNoColumns) *shared = columns;
  }
}

RowLine line_without_rows(const World& w) {
  RowLine line;
  line.fill(uint32_t(w.chunks.rows.size() - 1));
  return line;
}

// Lists the points of a group by gridpoint: first those on the sides of blocks b, then those of blocks a. And the
// moments on the frames of blocks a.
void list_lines(const World& w, std::span<const int32_t> blocks, std::vector<GridpointLine>& lines,
                std::vector<RowLine>& moments) {
  const int node_count = most_gridpoints(w, blocks);
  lines.clear(), moments.clear();
  for (size_t l = 0; l < blocks.size(); ++l) {
    size_t line = 0;
    for (const RowTouch row : w.sides.moment.of(blocks[l])) {
      if (line == moments.size()) moments.push_back(line_without_rows(w));
      moments[line++][l] = row;
    }
  }
  std::vector<uint32_t> used(size_t(node_count), 0), next = used;
  for (const bool side_a : {false, true}) {
    const auto& sides = side_a ? w.sides.owner_gridpoint : w.sides.gridpoint;
    std::fill(next.begin(), next.end(), 0);  // first as many lines as a block has points on the gridpoint
    for (const int32_t block : blocks) {
      std::fill(used.begin(), used.end(), 0);
      for (const GridpointTouch& touch : sides.of(block)) {
        const size_t node = size_t(touch.node);
        next[node] = std::max(next[node], ++used[node]);
      }
    }
    for (int32_t node = 0; node < node_count; ++node) {
      const uint32_t count = std::exchange(next[size_t(node)], uint32_t(lines.size()));
      lines.resize(lines.size() + count, {node, side_a, line_without_rows(w)});
    }
    for (size_t l = 0; l < blocks.size(); ++l) {
      std::fill(used.begin(), used.end(), 0);
      for (const GridpointTouch& touch : sides.of(blocks[l])) {
        const size_t node = size_t(touch.node);
        lines[next[node] + used[node]++].row[l] = touch.row;
      }
    }
  }
}

int zones_of(const World& w, const Unit& unit) {
  int zones = 0;
  for (const int block : unit.blocks()) zones += w.blocks[size_t(block)].zone_count;
  return zones;
}

using Kinds = std::array<int32_t, 2>;  // congruent kinds of a unit's blocks

bool has_fixed_frames(const World& w, const Unit& unit) {
  return std::ranges::all_of(unit.blocks(), [&](int block) { return w.frames.fixed[size_t(block)]; });
}

// Divides those units of the list that have `count` blocks, which are apart or not, in its order into pieces.
void append_pieces(World& w, std::span<const Unit> units, Piece::Kind kind, const Kinds& congruent, int count,
                   bool apart) {
  const bool one_by_one = kind == Piece::Kind::distinct || kind == Piece::Kind::by_zone;
  // Bound of zones in a piece whose blocks have one product each, so that threads share the work.
  const int most_zones = one_by_one ? int(std::clamp(w.zone_count() / 16, size_t(500), size_t(4000))) : 0;
  const bool halves = count == 2 && (!apart || congruent[0] != congruent[1]);
  std::vector<Unit> together;
  int zones = 0;
  const auto put = [&] {
    if (together.empty()) return;
    w.pieces.all.push_back({uint32_t(w.pieces.blocks.size()),
                            uint32_t(count) * uint32_t(together.size()),
                            halves,
                            apart,
                            kind,
                            {congruent[0], halves ? congruent[1] : -1}});
    w.pieces.all.back().fixed = kind == Piece::Kind::congruent && has_fixed_frames(w, together.front());
    for (int half = 0; half < count; ++half) {
      for (const Unit& unit : together) w.pieces.blocks.push_back(unit.block[half]);
    }
    together.clear(), zones = 0;
  };
  for (const Unit& unit : units) {
    if (unit.count != count || apart != (count == 2 && w.units.apart[size_t(unit.block[0])])) continue;
    const bool is_full = int(together.size() + 1) * (halves ? 1 : count) > kBodies;
    if (is_full || (one_by_one && zones + zones_of(w, unit) > most_zones)) put();
    together.push_back(unit), zones += zones_of(w, unit);
  }
  put();
}

// Halves that are apart stay in one piece, so that one rank has both when they join again.
void append_pieces(World& w, std::span<const Unit> units, Piece::Kind kind, const Kinds& congruent = {-1, -1}) {
  append_pieces(w, units, kind, congruent, 1, false);
  append_pieces(w, units, kind, congruent, 2, false);
  append_pieces(w, units, kind, congruent, 2, true);
}

}  // namespace

// Divides blocks into pieces of as many as a SIMD group holds. Units of congruent blocks are grouped by the kinds of
// their halves, so that most groups are full. Where a kind has few blocks, their forces are computed zone by zone.
// Other units are grouped by size, so that lanes of a group have similar lengths.
void divide_blocks(World& w) {
  w.pieces.all.clear(), w.pieces.blocks.clear();
  std::vector<Unit> rigid, held_rigid, distinct, by_zone;
  std::map<Kinds, std::vector<Unit>> of_kinds[2];            // in frames that follow the blocks, in fixed frames
  std::vector<size_t> of_kind(w.zones.congruent.size(), 0);  // number of blocks
  for (int i = 0; i < w.block_count(); ++i) {
    if (w.blocks[size_t(i)].body >= 0) {
      (w.assembly.blocks[size_t(i)].fixed ? held_rigid : rigid).push_back({{i, -1}, 1});
      continue;
    }
    const Unit unit = w.units.of(i, Units::Halves::also_apart);
    if (unit.block[0] != i) continue;  // in the piece of the first half
    const bool leaves = w.frames.by_zone[size_t(i)] || w.frames.by_zone[size_t(unit.block[size_t(unit.count) - 1])];
    Kinds kinds{-1, -1};
    for (size_t k = 0; k < size_t(unit.count); ++k) kinds[k] = w.blocks[size_t(unit.block[k])].congruent;
    if (leaves) {
      by_zone.push_back(unit);
    } else if (kinds[0] < 0) {
      distinct.push_back(unit);
    } else {
      of_kinds[has_fixed_frames(w, unit)][kinds].push_back(unit);
      for (size_t k = 0; k < size_t(unit.count); ++k) ++of_kind[size_t(kinds[k])];
    }
  }
  for (const bool in_fixed_frames : {false, true}) {  // fixed frames stay, however few there are
    for (const auto& [kinds, units] : of_kinds[in_fixed_frames]) {
      const auto has_few = [&](int32_t kind) { return kind >= 0 && of_kind[size_t(kind)] < kFewestCongruent; };
      if (in_fixed_frames || std::ranges::none_of(kinds, has_few))
        append_pieces(w, units, Piece::Kind::congruent, kinds);
      else
        by_zone.insert(by_zone.end(), units.begin(), units.end());
    }
  }
  std::stable_sort(distinct.begin(), distinct.end(),
                   [&](const Unit& a, const Unit& b) { return zones_of(w, a) > zones_of(w, b); });
  append_pieces(w, distinct, Piece::Kind::distinct);
  append_pieces(w, by_zone, Piece::Kind::by_zone);
  append_pieces(w, rigid, Piece::Kind::rigid);
  append_pieces(w, held_rigid, Piece::Kind::rigid);  // mostly at rest: so are their pieces as a whole
  w.pieces.needs_check.assign(w.pieces.all.size(), 0);
  w.pieces.in_frame.assign(w.blocks.size(), 0);
  for (const Piece& piece : w.pieces.all) {
    for (const int32_t i : w.pieces.blocks_of(piece)) w.pieces.in_frame[size_t(i)] = piece.in_frame();
  }
}

namespace {

// Binds pieces to columns, and to the memory of positions and velocities.
void bind_columns_of_pieces(World& w) {
  w.pieces.columns.clear(), w.pieces.held_changed.clear();
  w.pieces.shared_columns.assign(4 * w.zones.congruent.size(), Piece::kNoColumns);
  w.pieces.any_held_changed = false;
  w.pieces.of_block.assign(w.blocks.size(), -1), w.pieces.lane_of_block.assign(w.blocks.size(), -1);
  size_t motion = 0;
  for (Piece& piece : w.pieces.all) {
    std::fill(piece.columns, std::end(piece.columns), Piece::kNoColumns);
    if (piece.kind == Piece::Kind::rigid || !w.part.owns(w.pieces.blocks_of(piece).front())) continue;
    fill_columns(w, piece);
    for (const int32_t block : w.pieces.blocks_of(piece))
      w.pieces.of_block[size_t(block)] = int32_t(&piece - w.pieces.all.data());
    for (size_t group = 0; piece.kind == Piece::Kind::congruent && group < piece.group_count(); ++group) {
      const std::span<const int32_t> blocks = w.pieces.blocks_of(piece, group);
      piece.motion[group] = std::exchange(motion, motion + 2 * size_t(most_gridpoints(w, blocks)) * kLine);
      for (size_t l = 0; l < blocks.size(); ++l)
        w.pieces.lane_of_block[size_t(blocks[l])] = std::int64_t(piece.motion[group] + l);
    }
  }
  w.pieces.motion.resize(motion);
  w.pieces.motion_is_old = true;
}

}  // namespace

void bind_pieces(World& w) {
  if (w.pieces.are_old || w.part.ranks) bind_columns_of_pieces(w);
  w.pieces.are_old = false;
  constexpr size_t kPiecesAPart = 4;  // of the work of one thread at a time
  const auto bind = [&](Piece& piece) {
    if (!piece.in_frame() || !w.part.owns(w.pieces.blocks_of(piece).front())) return;
    piece.other_sides = std::ranges::any_of(w.pieces.blocks_of(piece), [&](int32_t block) {
      return !w.sides.owner.of(block).empty() || !w.sides.carrier.of(block).empty() ||
             !w.sides.single.of(block).empty();
    });
    for (size_t group = 0; group < piece.group_count(); ++group)
      list_lines(w, w.pieces.blocks_of(piece, group), piece.lines[group], piece.moments[group]);
  };
  each_part(w.pool, w.pieces.all.size(), kPiecesAPart, [&](size_t begin, size_t end) {
    std::ranges::for_each(std::span(w.pieces.all).subspan(begin, end - begin), bind);
  });
}

void follow_held(World& w) {
  if (!w.pieces.any_held_changed && w.pieces.held_changed.empty()) return;
  if (w.pieces.any_held_changed) {
    for (int i = 0; i < w.block_count(); ++i) w.pieces.held_changed.push_back(i);
  }
  std::set<int32_t> changed;
  for (const int block : w.pieces.held_changed) {
    if (const int32_t piece = w.pieces.of_block[size_t(block)]; piece >= 0) changed.insert(piece);
  }
  for (const int32_t piece : changed) fill_columns(w, w.pieces.all[size_t(piece)]);
  w.pieces.held_changed.clear();
  w.pieces.any_held_changed = false;
}

void copy_velocities(World& w) {
  if (!w.pieces.velocities_lag) return;
  for (int i = 0; i < w.block_count(); ++i) {
    const ModelBlock& b = w.blocks[size_t(i)];
    for (int n = 0; w.pieces.lane_of_block[size_t(i)] >= 0 && n < b.node_count; ++n)
      w.nodes.v[size_t(b.first_node + n)] = gridpoint_velocity(w, i, n);
  }
  w.pieces.velocities_lag = false;
}

int most_gridpoints(const World& w, std::span<const int32_t> blocks) {
  int most = 0;
  for (const int32_t i : blocks) most = std::max(most, w.blocks[size_t(i)].node_count);
  return most;
}

int count_of(const World& w, Piece::Kind kind) {
  int count = 0;
  for (const Piece& piece : w.pieces.all) count += piece.kind == kind ? int(piece.count) : 0;
  return count;
}

double piece_work(const World& w, int index) {
  // Cost in units of one side of a contact point; a pair of rigid blocks counts one. A zone of congruent blocks costs a
  // quarter of one with a stiffness of its own, as eight blocks share a product.
  constexpr double kZone = 2.0, kDistinctZone = 1.0, kCongruentZone = 4.0, kBody = 3.0;
  const Piece& piece = w.pieces.all[size_t(index)];
  double work = 0.0;
  for (const int32_t i : w.pieces.blocks_of(piece)) {
    work += w.sides.cost[size_t(i)];
    const int of_block = w.blocks[size_t(i)].zone_count;
    if (piece.kind == Piece::Kind::rigid) work += kBody;
    if (piece.kind == Piece::Kind::distinct) work += kDistinctZone * of_block;
    if (piece.kind == Piece::Kind::by_zone) work += kZone * of_block;
  }
  for (size_t g = 0; piece.kind == Piece::Kind::congruent && g < piece.group_count(); ++g)
    work += kCongruentZone * w.blocks[size_t(w.pieces.blocks_of(piece, g).front())].zone_count;
  return work;
}

}  // namespace quoin::blocks
