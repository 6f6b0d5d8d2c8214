// Division of the work: contact points in runs for one call of their law.
#include "model/chunks.h"

#include <algorithm>

#include "model/contact_frames.h"
#include "model/contact_lists.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

void list_contacts_by_family(World& w) {
  for (auto& of_family : w.contacts.of_family) of_family.clear();
  for (size_t i = 0; i < w.contacts.list.size(); ++i) {
    if (w.contacts.list[i].count > 0) w.contacts.of_family[size_t(w.contacts.list[i].family)].push_back(uint32_t(i));
  }
}

namespace {

PairAxes pair_axes(const Vector& n, const Vector& s, const Vector& t) {
  return {{{n.x, n.y, n.z, 0.0}, {s.x, s.y, s.z, 0.0}, {t.x, t.y, t.z, 0.0}}};
}

bool same(const Vector& a, const Vector& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

void number_chunks(World& w) {
  w.chunks.all.clear(), w.chunks.own.clear();
  list_contacts_by_family(w);
  for (size_t k = 0; k < w.contacts.families.size(); ++k) {
    Family& f = w.contacts.families[k];
    for (auto* column : {&f.arm[0], &f.arm[1], &f.arm[2], &f.offset, &f.area}) {
      if (column->size() != f.size()) *column = LaneVector<double>(f.size());
    }
    for (uint32_t first = 0; first < f.size(); first += kChunk) {
      Chunk& chunk = w.chunks.all.emplace_back();
      chunk.family = int(k), chunk.first = first;
      chunk.count = std::min(kChunk, uint32_t(f.size()) - first);
    }
  }
}

void put_on_gridpoints(const World& w, const Point& p, uint32_t i, Chunk& chunk) {
  const auto put = [&](std::vector<int32_t>& nodes, int32_t facet) {
    nodes.resize(chunk.count + size_t(kLanes) - 1);  // kernels read whole vectors
    if (facet >= 0) nodes[i - chunk.first] = w.contacts.facets[size_t(facet)].node[0];
  };
  put(chunk.node_a, p.facet_a), put(chunk.node_b, p.facet_b);
  GridpointPair* const last = chunk.gridpoint_pairs.empty() ? nullptr : &chunk.gridpoint_pairs.back();
  const bool goes_on = last && last->a == p.a && last->b == p.b && last->first + last->count == i &&
                       same(last->axis[0], p.n) && same(last->axis[1], p.s);
  if (goes_on) {
    ++last->count;
  } else {
    chunk.gridpoint_pairs.push_back({p.a, p.b, w.blocks[size_t(p.b)].body, i, 1, chunk.row_count, 0, {p.n, p.s, p.t}});
    if (w.is_small) {  // axes are constant
      const Matrix r = start_of_frame(w, p.a);
      chunk.pair_axes.push_back(pair_axes(r * p.n, r * p.s, r * p.t));
    }
  }
  ++chunk.row_count;
}

// Gradients in small displacements, where frames are constant. In large motion each step computes them.
ShapeGradients gradients_at_rest(const World& w, const Facet& facet) {
  return w.is_small ? triangle_frame(w.nodes.reference, facet).gradient : ShapeGradients{};
}

void put_in_lanes(const World& w, const Point& p, uint32_t i, Chunk& chunk) {
  constexpr int kCount = FacetLanes::kCount;
  std::vector<FacetLanes>& all = chunk.facets;
  if (all.empty() || all.back().count == kCount || all.back().first + all.back().count != i) {
    all.emplace_back().first = i;
    all.back().row = chunk.row_count;
    all.back().on_gridpoints = true;
    if (w.is_small) chunk.frames.emplace_back();
  }
  FacetLanes& lanes = all.back();
  const Facet &a = w.contacts.facets[size_t(p.facet_a)], &b = w.contacts.facets[size_t(p.facet_b)];
  lanes.on_gridpoints = lanes.on_gridpoints && sits_on_gridpoint(b);
  const ShapeGradients gradient = gradients_at_rest(w, a);
  const double slope[3] = {gradient[1][0], gradient[1][1], gradient[2][1]};
  for (int l = int(lanes.count); l < kCount; ++l) {
    lanes.facet_a[l] = p.facet_a;
    lanes.reference[l] = p.reference, lanes.area[l] = p.area;
    for (int k = 0; k < 3; ++k) {
      lanes.node_a[k][l] = a.node[k], lanes.node_b[k][l] = b.node[k];
      lanes.weight_a[k][l] = a.weight[k], lanes.weight_b[k][l] = b.weight[k];
      if (!w.is_small) continue;
      FacetFrames& frames = chunk.frames.back();
      frames.n[k][l] = p.n[k], frames.s[k][l] = p.s[k], frames.t[k][l] = p.t[k];
      frames.slope[k][l] = slope[k];
    }
  }
  ++lanes.count;
  chunk.row_count += FacetRow::kCount;
}

// Rows are numbered from the first of the chunk.
void bind_points(const World& w, Chunk& chunk) {
  const Family& f = w.contacts.families[size_t(chunk.family)];
  for (uint32_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    const Point& p = f.point[i];
    if (p.on_gridpoints) {
      put_on_gridpoints(w, p, i, chunk);
      continue;
    }
    if (p.facet_a >= 0 && p.facet_b >= 0) {
      put_in_lanes(w, p, i, chunk);
      continue;
    }
    if (p.facet_a >= 0 || p.facet_b >= 0) {
      const bool on_a = p.facet_a >= 0;
      chunk.others.push_back(
          {i, on_a ? gradients_at_rest(w, w.contacts.facets[size_t(p.facet_a)]) : ShapeGradients{}, {}, {}});
      continue;
    }
    const int32_t a = w.blocks[size_t(p.a)].body, b = w.blocks[size_t(p.b)].body;
    const RigidPair* last = chunk.pairs.empty() ? nullptr : &chunk.pairs.back();
    const bool goes_on = last && last->a == a && last->b == b && last->first + last->count == i &&
                         same(last->axis[0], p.n) && same(last->axis[1], p.s);
    if (goes_on)
      ++chunk.pairs.back().count;
    else
      chunk.pairs.push_back({a, b, i, 1, {p.n, p.s, p.t}, {}, {}, {}, {}});
  }
  for (GridpointPair& pair : chunk.gridpoint_pairs)
    pair.sums = std::exchange(chunk.row_count, chunk.row_count + (pair.has_body() ? 3 : 1));
}

void unbind(Chunk& chunk) {
  chunk.pairs.clear(), chunk.facets.clear(), chunk.frames.clear(), chunk.others.clear();
  chunk.gridpoint_pairs.clear(), chunk.pair_axes.clear();
  chunk.node_a.clear(), chunk.node_b.clear();
  chunk.row_count = 0, chunk.call.batch = {};
}

// Rows of own chunks follow each other.
void number_rows(World& w) {
  uint32_t first = 0;
  for (const int c : w.chunks.own) {
    Chunk& chunk = w.chunks.all[size_t(c)];
    for (GridpointPair& pair : chunk.gridpoint_pairs) pair.row += first, pair.sums += first;
    for (FacetLanes& lanes : chunk.facets) lanes.row += first;
    first += chunk.row_count;
  }
  w.chunks.rows.clear();
  w.chunks.rows.resize(first + 1);
}

}  // namespace

void divide_work(World& w) {
  number_chunks(w);
  count_sides(w);
  if (w.pieces.are_old) copy_velocities(w), divide_blocks(w);
  w.step_sums.of_block.resize(w.blocks.size());
  w.actions.loaded.resize(w.blocks.size(), 0);
  ++w.chunks.divisions;
  if (!w.part.ranks) bind_work(w);
}

void pack_viscosity(const World& w, Chunk& chunk) {
  for (auto& column : chunk.viscosity) column.assign(w.damping.impacts ? chunk.count : 0, 0.0);
  if (!w.damping.impacts) return;
  each_contact_of_chunk(w, int(&chunk - w.chunks.all.data()), [&](size_t i) {
    const Contact& c = w.contacts.list[i];
    const uint32_t begin = std::max(c.first, chunk.first), end = std::min(c.first + c.count, chunk.first + chunk.count);
    for (size_t k = 0; k < 2; ++k)
      std::fill_n(chunk.viscosity[k].begin() + (begin - chunk.first), end - begin, w.contacts.place[i].viscosity[k]);
  });
}

void pack(World& w, Chunk& chunk) {
  pack_viscosity(w, chunk);
  Family& f = w.contacts.families[size_t(chunk.family)];
  for (size_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    const Point& p = f.point[i];
    for (int c = 0; c < 3 && p.facet_b < 0; ++c) f.arm[c][i] = p.arm[c];
    f.offset[i] = p.on_gridpoints ? p.reference : p.offset, f.area[i] = p.area;
  }
}

// Binds the data that steps read: of the chunks that touch own blocks, and of own blocks.
void bind_work(World& w) {
  w.chunks.own.clear();
  for (int c = 0; c < w.chunk_count(); ++c) {
    bool own = !w.part.ranks;
    if (w.part.ranks) each_block_of_chunk(w, c, [&](int block) { own |= w.part.owns(block); });
    if (own)
      w.chunks.own.push_back(c);
    else
      unbind(w.chunks.all[size_t(c)]);
  }
  each_part(w.pool, w.chunks.own.size(), 1, [&](size_t begin, size_t) {
    Chunk& chunk = w.chunks.all[size_t(w.chunks.own[begin])];
    unbind(chunk);
    Family& f = w.contacts.families[size_t(chunk.family)];
    for (uint32_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
      if (f.point[i].on_gridpoints && !w.pieces.in_frame[size_t(f.point[i].a)]) leave_gridpoints(w, f, i);
    }
    pack(w, chunk);
    bind_points(w, chunk);
  });
  number_rows(w);
  bind_columns(w);
  divide_sides(w);
  bind_pieces(w);
}

void bind_columns(World& w) {
  for (const int c : w.chunks.own)
    bind(w, w.contacts.families[size_t(w.chunks.all[size_t(c)].family)], w.chunks.all[size_t(c)]);
}

void bind(const World& w, Family& f, Chunk& chunk) {
  CallColumns columns{chunk.count, {}, {}, batch_columns(f.columns, *f.material, chunk.first)};
  for (size_t k = 0; k < 3; ++k) columns.traction[k] = f.traction[k].data() + chunk.first;
  for (auto& column : f.state) columns.state.push_back(column.data() + chunk.first);
  chunk.call.bind(std::move(columns));
  chunk.call.bind_jumps(f.normal_jump.data() + chunk.first, f.slip[0].data() + chunk.first,
                        f.slip[1].data() + chunk.first);
  if (!w.books_energy || f.stored.empty() || !(f.material->api().capabilities & QUOIN_CAN_ENERGY)) return;
  std::array<double*, QUOIN_DISSIPATED_COUNT> dissipated;
  for (size_t k = 0; k < dissipated.size(); ++k) dissipated[k] = f.dissipated[k].data() + chunk.first;
  chunk.call.bind_energies(f.stored.data() + chunk.first, dissipated);
}

}  // namespace quoin::blocks
