// Who does what: contact points in runs for one call of their law, the sides of points that a block fetches, and what
// both cost.
#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "model/world.h"

namespace quoin::blocks {

namespace {

// Sides of something, of own blocks, counted and then filled in block after block.
template <class Side, class Owns, class ForEach>
void by_block(size_t blocks, ByBlock<Side>& sides, Owns owns, ForEach for_each) {
  std::vector<uint32_t>& end = sides.end;
  end.assign(blocks, 0);
  for_each([&](int block, const Side&) { end[size_t(block)] += owns(block) ? 1 : 0; });
  std::vector<uint32_t> next(blocks, 0);
  for (size_t i = 0, sum = 0; i < blocks; ++i) {
    next[i] = uint32_t(sum);
    sum += end[i];
    end[i] = uint32_t(sum);
  }
  sides.touch.resize(end.empty() ? 0 : end.back());
  for_each([&](int block, const Side& side) {
    if (owns(block)) sides.touch[next[size_t(block)]++] = side;
  });
}

PairAxes pair_axes(const Vector& n, const Vector& s, const Vector& t) {
  return {{{n.x, n.y, n.z, 0.0}, {s.x, s.y, s.z, 0.0}, {t.x, t.y, t.z, 0.0}}};
}

bool same(const Vector& a, const Vector& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

}  // namespace

void World::divide_work() {
  number_chunks();
  count_sides();
  divide_blocks();
  step_sums_.of_block.resize(blocks_.size());
  actions_.loaded.resize(blocks_.size(), 0);
  ++chunks_.divisions;
  if (!part_.ranks) bind_work();
}

void World::number_chunks() {
  chunks_.all.clear(), chunks_.own.clear();
  for (auto& of_family : contacts_.of_family) of_family.clear();
  for (size_t i = 0; i < contacts_.list.size(); ++i) {
    if (contacts_.list[i].count > 0) contacts_.of_family[size_t(contacts_.list[i].family)].push_back(uint32_t(i));
  }
  for (size_t k = 0; k < contacts_.families.size(); ++k) {
    Family& f = contacts_.families[k];
    for (auto* column : {&f.arm[0], &f.arm[1], &f.arm[2], &f.offset, &f.area}) {
      if (column->size() != f.size()) *column = LaneVector<double>(f.size());
    }
    for (uint32_t first = 0; first < f.size(); first += kChunk) {
      Chunk& chunk = chunks_.all.emplace_back();
      chunk.family = int(k), chunk.first = first;
      chunk.count = std::min(kChunk, uint32_t(f.size()) - first);
    }
  }
}

// What steps read: of the chunks that touch own blocks, and of own blocks.
void World::bind_work() {
  chunks_.own.clear(), chunks_.rows.clear();
  for (int c = 0; c < chunk_count(); ++c) {
    Chunk& chunk = chunks_.all[size_t(c)];
    chunk.pairs.clear(), chunk.facets.clear(), chunk.frames.clear(), chunk.others.clear();
    chunk.gridpoint_pairs.clear(), chunk.pair_axes.clear(), chunk.node_a.clear(), chunk.node_b.clear();
    bool own = !part_.ranks;
    if (part_.ranks) each_block_of_chunk(c, [&](int block) { own |= owns(block); });
    if (!own) {
      chunk.batch = {};
      continue;
    }
    chunks_.own.push_back(c);
    Family& f = contacts_.families[size_t(chunk.family)];
    for (uint32_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
      if (f.point[i].on_gridpoints && !pieces_.in_frame[size_t(f.point[i].a)]) leave_gridpoints(f, i);
    }
    pack(chunk);
    bind_points(chunk);
  }
  bind_columns();
  divide_sides();
  pieces_.columns.clear(), pieces_.held_changed.clear();
  pieces_.shared_columns.assign(2 * zones_.congruent.size(), Piece::kNoColumns);
  pieces_.any_held_changed = false;
  pieces_.of_block.assign(blocks_.size(), -1);
  for (Piece& piece : pieces_.all) {
    std::fill(piece.columns, std::end(piece.columns), Piece::kNoColumns);
    if (piece.kind == Piece::Kind::rigid || !owns(pieces_.blocks_of(piece).front())) continue;
    fill_columns(piece);
    for (const int32_t block : pieces_.blocks_of(piece))
      pieces_.of_block[size_t(block)] = int32_t(&piece - pieces_.all.data());
  }
}

void World::follow_held() {
  if (!pieces_.any_held_changed && pieces_.held_changed.empty()) return;
  if (pieces_.any_held_changed) {
    for (int i = 0; i < block_count(); ++i) pieces_.held_changed.push_back(i);
  }
  std::set<int32_t> changed;
  for (const int block : pieces_.held_changed) {
    if (const int32_t piece = pieces_.of_block[size_t(block)]; piece >= 0) changed.insert(piece);
  }
  for (const int32_t piece : changed) fill_columns(pieces_.all[size_t(piece)]);
  pieces_.held_changed.clear();
  pieces_.any_held_changed = false;
}

void World::pack(const Chunk& chunk) {
  Family& f = contacts_.families[size_t(chunk.family)];
  for (size_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    const Point& p = f.point[i];
    for (int c = 0; c < 3; ++c) f.arm[c][i] = p.arm[c];
    f.offset[i] = p.on_gridpoints ? p.reference : p.offset, f.area[i] = p.area;
  }
}

void World::bind_points(Chunk& chunk) {
  const Family& f = contacts_.families[size_t(chunk.family)];
  for (uint32_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    const Point& p = f.point[i];
    if (p.on_gridpoints) {
      put_on_gridpoints(p, i, chunk);
      continue;
    }
    if (p.facet_a >= 0 && p.facet_b >= 0) {
      put_in_lanes(p, i, chunk);
      continue;
    }
    if (p.facet_a >= 0 || p.facet_b >= 0) {
      chunk.others.push_back(i);
      continue;
    }
    const int32_t a = blocks_[size_t(p.a)].body, b = blocks_[size_t(p.b)].body;
    const RigidPair* last = chunk.pairs.empty() ? nullptr : &chunk.pairs.back();
    const bool goes_on = last && last->a == a && last->b == b && last->first + last->count == i &&
                         same(last->axis[0], p.n) && same(last->axis[1], p.s);
    if (goes_on)
      ++chunk.pairs.back().count;
    else
      chunk.pairs.push_back({a, b, i, 1, {p.n, p.s, p.t}, {}, {}, {}, {}});
  }
}

// Each point of a pair has one at both blocks; where these are rigid, all of them together.
void World::count_sides() {
  sides_.cost.assign(blocks_.size(), 0.0);
  for (const Contact& c : contacts_.list) {
    if (c.count == 0) continue;
    const double sides = facets_a_point(c) == 0 ? 1.0 : double(c.count);
    sides_.cost[size_t(c.pair.a)] += sides, sides_.cost[size_t(c.pair.b)] += sides;
  }
}

void World::put_on_gridpoints(const Point& p, uint32_t i, Chunk& chunk) {
  const auto put = [&](std::vector<int32_t>& nodes, int32_t facet) {
    nodes.resize(chunk.count + size_t(kLanes) - 1);  // kernels read whole vectors
    nodes[i - chunk.first] = contacts_.facets[size_t(facet)].node[0];
  };
  put(chunk.node_a, p.facet_a), put(chunk.node_b, p.facet_b);
  GridpointPair* const last = chunk.gridpoint_pairs.empty() ? nullptr : &chunk.gridpoint_pairs.back();
  const bool goes_on = last && last->a == p.a && last->b == p.b && last->first + last->count == i &&
                       same(last->axis[0], p.n) && same(last->axis[1], p.s);
  if (goes_on) {
    ++last->count;
  } else {
    chunk.gridpoint_pairs.push_back({p.a, p.b, i, 1, uint32_t(chunks_.rows.size()), {p.n, p.s, p.t}, {}});
    if (small_) {  // they stay so
      const Matrix r = start_of_frame(p.a);
      chunk.pair_axes.push_back(pair_axes(r * p.n, r * p.s, r * p.t));
    }
  }
  chunks_.rows.resize(chunks_.rows.size() + 1);
}

void World::put_in_lanes(const Point& p, uint32_t i, Chunk& chunk) {
  constexpr int kCount = FacetLanes::kCount;
  std::vector<FacetLanes>& all = chunk.facets;
  if (all.empty() || all.back().count == kCount || all.back().first + all.back().count != i) {
    all.emplace_back().first = i;
    all.back().row = uint32_t(chunks_.rows.size());
    all.back().on_gridpoints = true;
    if (small_) chunk.frames.emplace_back();
  }
  FacetLanes& lanes = all.back();
  const Facet &a = contacts_.facets[size_t(p.facet_a)], &b = contacts_.facets[size_t(p.facet_b)];
  lanes.on_gridpoints = lanes.on_gridpoints && sits_on_gridpoint(b);
  const double slope[3] = {a.gradient[1][0], a.gradient[1][1], a.gradient[2][1]};
  for (int l = int(lanes.count); l < kCount; ++l) {
    lanes.facet_a[l] = p.facet_a;
    lanes.reference[l] = p.reference, lanes.area[l] = p.area;
    for (int k = 0; k < 3; ++k) {
      lanes.node_a[k][l] = a.node[k], lanes.node_b[k][l] = b.node[k];
      lanes.weight_a[k][l] = a.weight[k], lanes.weight_b[k][l] = b.weight[k];
      if (!small_) continue;
      FacetFrames& frames = chunk.frames.back();
      frames.n[k][l] = p.n[k], frames.s[k][l] = p.s[k], frames.t[k][l] = p.t[k];
      frames.slope[k][l] = slope[k];
    }
  }
  ++lanes.count;
  chunks_.rows.resize(chunks_.rows.size() + FacetRow::kCount);
}

void World::divide_sides() {
  const auto own = [this](int block) { return owns(block); };
  by_block(blocks_.size(), sides_.single, own, [&](const auto& visit) {
    for (const int c : chunks_.own) {
      const Chunk& chunk = chunks_.all[size_t(c)];
      for (const uint32_t i : chunk.others) {
        const Point& p = contacts_.families[size_t(chunk.family)].point[i];
        visit(p.a, Touch{chunk.family, i, true});
        visit(p.b, Touch{chunk.family, i, false});
      }
    }
  });
  const auto each_facet_point = [&](const auto& visit) {  // (point, its first row)
    for (const int c : chunks_.own) {
      const Chunk& chunk = chunks_.all[size_t(c)];
      for (const FacetLanes& lanes : chunk.facets) {
        for (uint32_t l = 0; l < lanes.count; ++l)
          visit(contacts_.families[size_t(chunk.family)].point[lanes.first + l], lanes.row + FacetRow::kCount * l);
      }
    }
  };
  const auto each_gridpoint_pair = [&](const auto& visit) {
    for (const int c : chunks_.own) {
      for (const GridpointPair& pair : chunks_.all[size_t(c)].gridpoint_pairs) visit(chunks_.all[size_t(c)], pair);
    }
  };
  const auto node_of = [&](const Facet& f, int corner, int block) {
    return f.node[corner] - blocks_[size_t(block)].first_node;
  };
  by_block(blocks_.size(), sides_.owner, own, [&](const auto& visit) {
    each_facet_point([&](const Point& p, uint32_t row) {
      const Facet& f = contacts_.facets[size_t(p.facet_a)];
      visit(p.a, OwnerTouch{row, {node_of(f, 0, p.a), node_of(f, 1, p.a), node_of(f, 2, p.a)}});
    });
  });
  by_block(blocks_.size(), sides_.carrier, own, [&](const auto& visit) {
    each_facet_point([&](const Point& p, uint32_t row) {
      const Facet& f = contacts_.facets[size_t(p.facet_b)];
      if (sits_on_gridpoint(f)) return;
      visit(p.b, CarrierTouch{row,
                              {node_of(f, 0, p.b), node_of(f, 1, p.b), node_of(f, 2, p.b)},
                              {f.weight[0], f.weight[1], f.weight[2]}});
    });
  });
  by_block(blocks_.size(), sides_.gridpoint, own, [&](const auto& visit) {
    each_facet_point([&](const Point& p, uint32_t row) {
      const Facet& f = contacts_.facets[size_t(p.facet_b)];
      if (sits_on_gridpoint(f)) visit(p.b, GridpointTouch{row, node_of(f, 0, p.b)});
    });
    each_gridpoint_pair([&](const Chunk& chunk, const GridpointPair& pair) {
      const int32_t first = blocks_[size_t(pair.b)].first_node;
      for (uint32_t k = 0; k < pair.count; ++k)
        visit(pair.b, GridpointTouch{pair.row + k, chunk.node_b[pair.first + k - chunk.first] - first});
    });
  });
  by_block(blocks_.size(), sides_.owner_gridpoint, own, [&](const auto& visit) {
    each_gridpoint_pair([&](const Chunk& chunk, const GridpointPair& pair) {
      const int32_t first = blocks_[size_t(pair.a)].first_node;
      for (uint32_t k = 0; k < pair.count; ++k)
        visit(pair.a, GridpointTouch{pair.row + k, chunk.node_a[pair.first + k - chunk.first] - first});
    });
  });
  by_block(blocks_.size(), sides_.moment, own, [&](const auto& visit) {
    each_gridpoint_pair([&](const Chunk&, const GridpointPair& pair) { visit(pair.a, MomentTouch(&pair)); });
  });
  by_block(blocks_.size(), sides_.pair, own, [&](const auto& visit) {
    for (const int c : chunks_.own) {
      const Chunk& chunk = chunks_.all[size_t(c)];
      for (const RigidPair& pair : chunk.pairs) {
        const Point& p = contacts_.families[size_t(chunk.family)].point[pair.first];
        visit(p.a, PairTouch{&pair, true});
        visit(p.b, PairTouch{&pair, false});
      }
    }
  });
}

// As many as a vector takes. Units of congruent blocks go by kind, so that most vectors are full; where few are left of
// a kind they go zone by zone. Of the others those of one size go together, so that lanes are as long as each other.
void World::divide_blocks() {
  pieces_.all.clear(), pieces_.blocks.clear();
  const auto zones_of = [&](const Unit& unit) {
    int zones = 0;
    for (const int block : unit.blocks()) zones += blocks_[size_t(block)].zone_count;
    return zones;
  };
  // Zones of a piece whose blocks go one by one, so that threads share them.
  const int most_zones = int(std::clamp(zone_count() / 16, size_t(500), size_t(4000)));
  // Of a list of units, in its order, those that go into one piece after the other. Halves that are apart stay in one
  // piece, so that one rank has both when they meet again.
  const auto divide = [&](std::span<const Unit> units, Piece::Kind kind, int32_t congruent = -1) {
    const bool one_by_one = kind == Piece::Kind::distinct || kind == Piece::Kind::by_zone;
    const auto of_one_kind = [&](int count, bool halves) {
      std::vector<Unit> together;
      int zones = 0;
      const auto put = [&] {
        if (together.empty()) return;
        pieces_.all.push_back(
            {uint32_t(pieces_.blocks.size()), uint32_t(count) * uint32_t(together.size()), halves, kind, congruent});
        for (int half = 0; half < count; ++half) {
          for (const Unit& unit : together) pieces_.blocks.push_back(unit.block[half]);
        }
        together.clear(), zones = 0;
      };
      for (const Unit& unit : units) {
        if (unit.count != count || halves != (count == 2 && !units_.apart[size_t(unit.block[0])])) continue;
        const bool is_full = int(together.size() + 1) * (halves ? 1 : count) > kBodies;
        if (is_full || (one_by_one && zones + zones_of(unit) > most_zones)) put();
        together.push_back(unit), zones += zones_of(unit);
      }
      put();
    };
    of_one_kind(1, false), of_one_kind(2, true), of_one_kind(2, false);
  };
  std::vector<Unit> rigid, fixed, distinct, by_zone;
  std::map<int32_t, std::vector<Unit>> of_kind;
  for (int i = 0; i < block_count(); ++i) {
    if (blocks_[size_t(i)].body >= 0) {
      (assembly_.blocks[size_t(i)].fixed ? fixed : rigid).push_back({{i, -1}, 1});
      continue;
    }
    const Unit unit = units_.of(i, Units::Halves::also_apart);
    if (unit.block[0] != i) continue;  // goes with the first half
    const bool leaves = frames_.by_zone[size_t(i)] || frames_.by_zone[size_t(unit.block[size_t(unit.count) - 1])];
    const int32_t kind = blocks_[size_t(i)].congruent;
    (leaves ? by_zone : (kind >= 0 ? of_kind[kind] : distinct)).push_back(unit);
  }
  for (const auto& [kind, units] : of_kind) {
    size_t blocks = 0;
    for (const Unit& unit : units) blocks += size_t(unit.count);
    if (blocks >= kFewestAlike)
      divide(units, Piece::Kind::congruent, kind);
    else
      by_zone.insert(by_zone.end(), units.begin(), units.end());
  }
  std::stable_sort(distinct.begin(), distinct.end(),
                   [&](const Unit& a, const Unit& b) { return zones_of(a) > zones_of(b); });
  divide(distinct, Piece::Kind::distinct);
  divide(by_zone, Piece::Kind::by_zone);
  divide(rigid, Piece::Kind::rigid);
  divide(fixed, Piece::Kind::rigid);  // which mostly stay at rest, all of a piece
  pieces_.in_frame.assign(blocks_.size(), 0);
  for (const Piece& piece : pieces_.all) {
    for (const int32_t i : pieces_.blocks_of(piece)) pieces_.in_frame[size_t(i)] = piece.in_frame();
  }
}

int World::most_gridpoints(const Piece& piece) const {
  int most = 0;
  for (const int32_t i : pieces_.blocks_of(piece)) most = std::max(most, blocks_[size_t(i)].node_count);
  return most;
}

// Groups of congruent blocks whose columns agree to the last bit read the same ones. Shapes that are congruent but for
// rounding have other masses.
void World::fill_columns(Piece& piece) {
  const std::span<const int32_t> all = pieces_.blocks_of(piece);
  const bool some_held = std::any_of(all.begin(), all.end(), [&](int32_t block) {
    const ModelBlock& b = blocks_[size_t(block)];
    const auto held = std::span(nodes_.held).subspan(size_t(b.first_node), size_t(b.node_count));
    return std::any_of(held.begin(), held.end(), [](uint8_t bits) { return bits != 0; });
  });
  const bool distinct = piece.kind == Piece::Kind::distinct;
  const int most = most_gridpoints(piece);
  thread_local LaneVector<double> numbers;
  numbers.assign(FixedColumns<double>::size(most, distinct, some_held), 0.0);
  for (size_t group = 0; group < piece.group_count(); ++group) {
    fill_columns(pieces_.blocks_of(piece, group), FixedColumns<double>(numbers.data(), most, distinct, some_held));
    size_t& columns = piece.columns[group];
    size_t* const shared = piece.kind == Piece::Kind::congruent
                               ? &pieces_.shared_columns[2 * size_t(piece.congruent) + some_held]
                               : nullptr;
    const auto agree = [&](size_t at) {
      return at != Piece::kNoColumns &&
             std::memcmp(pieces_.columns.data() + at, numbers.data(), numbers.size() * sizeof(double)) == 0;
    };
    if (shared && agree(*shared)) {
      columns = *shared;
      continue;
    }
    const bool stays = columns != Piece::kNoColumns && some_held == piece.some_held && !(shared && columns == *shared);
    if (!stays) columns = pieces_.columns.size(), pieces_.columns.resize(columns + numbers.size());
    std::copy(numbers.begin(), numbers.end(), pieces_.columns.begin() + std::ptrdiff_t(columns));
    if (shared && *shared == Piece::kNoColumns) *shared = columns;
  }
  piece.some_held = some_held;
}

void World::fill_columns(std::span<const int32_t> blocks, const FixedColumns<double>& to) const {
  for (size_t l = 0; l < size_t(kLanes); ++l) {
    const ModelBlock& b = blocks_[size_t(blocks[std::min(l, blocks.size() - 1)])];
    for (size_t n = 0; n < size_t(b.node_count); ++n) {
      const size_t node = size_t(b.first_node) + n;
      to.mass[n * kLanes + l] = nodes_.mass[node], to.over_mass[n * kLanes + l] = 1.0 / nodes_.mass[node];
      const Vector place = nodes_.reference[node] - nodes_.reference[size_t(b.first_node)];
      for (int c = 0; c < 3; ++c) {
        const size_t at = n * kLine + size_t(c) * kLanes + l;
        if (to.place) to.place[at] = place[c], to.anchor[at] = nodes_.anchor[node][c];
        if (to.held) to.held[at] = nodes_.held[node] >> c & 1, to.held_v[at] = nodes_.held_v[node][c];
      }
    }
  }
}

int World::count_of(Piece::Kind kind) const {
  int count = 0;
  for (const Piece& piece : pieces_.all) count += piece.kind == kind ? int(piece.count) : 0;
  return count;
}

double World::piece_work(int index) const {
  // In sides of contact points, of which a pair of rigid blocks has one. A zone of congruent blocks costs a quarter of
  // one with a stiffness of its own, as eight blocks share a product.
  constexpr double kZone = 2.0, kDistinctZone = 1.0, kCongruentZone = 4.0, kBody = 3.0;
  const Piece& piece = pieces_.all[size_t(index)];
  double work = 0.0;
  for (const int32_t i : pieces_.blocks_of(piece)) {
    work += sides_.cost[size_t(i)];
    const int zones = blocks_[size_t(i)].zone_count;
    if (piece.kind == Piece::Kind::rigid) work += kBody;
    if (piece.kind == Piece::Kind::distinct) work += kDistinctZone * zones;
    if (piece.kind == Piece::Kind::by_zone) work += kZone * zones;
  }
  if (piece.kind == Piece::Kind::congruent)
    work += kCongruentZone * double(piece.group_count()) * blocks_[size_t(pieces_.blocks[piece.first])].zone_count;
  return work;
}

void World::bind_columns() {
  for (const int c : chunks_.own)
    bind(contacts_.families[size_t(chunks_.all[size_t(c)].family)], chunks_.all[size_t(c)]);
}

void World::bind(Family& f, Chunk& chunk) const {
  quoin_batch& batch = chunk.batch;
  batch = {};
  batch.struct_size = sizeof batch;
  batch.count = chunk.count;
  batch.normal_jump = {f.normal_jump.data() + chunk.first, 1};
  for (int k = 0; k < 2; ++k) batch.slip_increment[k] = {f.slip[k].data() + chunk.first, 1};
  for (int k = 0; k < 3; ++k) {
    batch.traction_old[k] = {f.traction[k].data() + chunk.first, 1};
    batch.traction_new[k] = {f.traction[k].data() + chunk.first, 1};
  }
  chunk.state_old.clear(), chunk.state_new.clear();
  for (auto& column : f.state) {
    chunk.state_old.push_back({column.data() + chunk.first, 1});
    chunk.state_new.push_back({column.data() + chunk.first, 1});
  }
  batch.state_old = chunk.state_old.data(), batch.state_new = chunk.state_new.data();
  chunk.properties = batch_columns(f.columns, *f.material, chunk.first);
  batch.property_column_count = chunk.properties.size(), batch.property_columns = chunk.properties.data();
  if (!energy_ || f.stored.empty() || !(f.material->api().capabilities & QUOIN_CAN_ENERGY)) return;
  batch.energy_stored = {f.stored.data() + chunk.first, 1};
  for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) batch.dissipated[k] = {f.dissipated[k].data() + chunk.first, 1};
}

}  // namespace quoin::blocks
