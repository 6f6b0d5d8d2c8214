#include "model/sides.h"

#include <iterator>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Lists sides of own blocks: each(visit) calls visit(block, side) for each side.
template <class Side, class Each>
void by_block(const World& w, ByBlock<Side>& sides, const Each& each) {
  list_by_block(w.blocks.size(), sides, [&](const auto& visit) {
    each([&](int block, const Side& side) {
      if (w.part.owns(block)) visit(block, side);
    });
  });
}

template <class Visit>
void each_own_chunk(const World& w, const Visit& visit) {  // visit(chunk, points of its family)
  for (const int c : w.chunks.own) {
    const Chunk& chunk = w.chunks.all[size_t(c)];
    visit(chunk, w.contacts.families[size_t(chunk.family)].point);
  }
}

template <class Visit>
void each_facet_point(const World& w, const Visit& visit) {  // visit(point, its first row)
  each_own_chunk(w, [&](const Chunk& chunk, const auto& points) {
    for (const FacetLanes& lanes : chunk.facets) {
      for (uint32_t l = 0; l < lanes.count; ++l) visit(points[lanes.first + l], lanes.row + FacetRow::kCount * l);
    }
  });
}

template <class Visit>
void each_gridpoint_pair(const World& w, const Visit& visit) {  // visit(its chunk, pair)
  each_own_chunk(w, [&](const Chunk& chunk, const auto&) {
    for (const GridpointPair& pair : chunk.gridpoint_pairs) visit(chunk, pair);
  });
}

int32_t node_of(const World& w, const Facet& f, int corner, int block) {
  return f.node[corner] - w.blocks[size_t(block)].first_node;
}

void list_single(World& w) {
  by_block(w, w.sides.single, [&](const auto& visit) {
    each_own_chunk(w, [&](const Chunk& chunk, const auto& points) {
      for (const OtherPoint& other : chunk.others) {
        visit(points[other.index].a, Touch{&other, chunk.family, true});
        visit(points[other.index].b, Touch{&other, chunk.family, false});
      }
    });
  });
}

void list_owner(World& w) {
  by_block(w, w.sides.owner, [&](const auto& visit) {
    each_facet_point(w, [&](const Point& p, uint32_t row) {
      const Facet& f = w.contacts.facets[size_t(p.facet_a)];
      visit(p.a, OwnerTouch{row, {node_of(w, f, 0, p.a), node_of(w, f, 1, p.a), node_of(w, f, 2, p.a)}});
    });
  });
}

void list_carrier(World& w) {
  by_block(w, w.sides.carrier, [&](const auto& visit) {
    each_facet_point(w, [&](const Point& p, uint32_t row) {
      const Facet& f = w.contacts.facets[size_t(p.facet_b)];
      if (sits_on_gridpoint(f)) return;
      visit(p.b, CarrierTouch{row,
                              {node_of(w, f, 0, p.b), node_of(w, f, 1, p.b), node_of(w, f, 2, p.b)},
                              {f.weight[0], f.weight[1], f.weight[2]}});
    });
  });
}

void list_gridpoint(World& w) {
  by_block(w, w.sides.gridpoint, [&](const auto& visit) {
    each_facet_point(w, [&](const Point& p, uint32_t row) {
      const Facet& f = w.contacts.facets[size_t(p.facet_b)];
      if (sits_on_gridpoint(f)) visit(p.b, GridpointTouch{row, node_of(w, f, 0, p.b)});
    });
    each_gridpoint_pair(w, [&](const Chunk& chunk, const GridpointPair& pair) {
      const int32_t first = w.blocks[size_t(pair.b)].first_node;
      for (uint32_t k = 0; k < pair.count && !pair.has_body(); ++k)
        visit(pair.b, GridpointTouch{pair.row + k, chunk.node_b[pair.first + k - chunk.first] - first});
    });
  });
}

void list_owner_gridpoint(World& w) {
  by_block(w, w.sides.owner_gridpoint, [&](const auto& visit) {
    each_gridpoint_pair(w, [&](const Chunk& chunk, const GridpointPair& pair) {
      const int32_t first = w.blocks[size_t(pair.a)].first_node;
      for (uint32_t k = 0; k < pair.count; ++k)
        visit(pair.a, GridpointTouch{pair.row + k, chunk.node_a[pair.first + k - chunk.first] - first});
    });
  });
}

void list_moment(World& w) {
  by_block(w, w.sides.moment, [&](const auto& visit) {
    each_gridpoint_pair(w, [&](const Chunk&, const GridpointPair& pair) { visit(pair.a, pair.sums); });
  });
}

void list_wrench(World& w) {
  by_block(w, w.sides.wrench, [&](const auto& visit) {
    each_gridpoint_pair(w, [&](const Chunk&, const GridpointPair& pair) {
      if (pair.has_body()) visit(pair.b, pair.sums + 1);
    });
  });
}

void list_pair(World& w) {
  by_block(w, w.sides.pair, [&](const auto& visit) {
    each_own_chunk(w, [&](const Chunk& chunk, const auto& points) {
      for (const RigidPair& pair : chunk.pairs) {
        visit(points[pair.first].a, PairTouch{&pair, true});
        visit(points[pair.first].b, PairTouch{&pair, false});
      }
    });
  });
}

}  // namespace

// A contact point has one side on each block; a pair of rigid blocks has one for all its points.
void count_sides(World& w) {
  w.sides.cost.assign(w.blocks.size(), 0.0);
  for (const Contact& c : w.contacts.list) {
    if (c.count == 0) continue;
    const double sides = facets_a_point(w, c) == 0 ? 1.0 : double(c.count);
    w.sides.cost[size_t(c.pair.a)] += sides, w.sides.cost[size_t(c.pair.b)] += sides;
  }
}

void divide_sides(World& w) {
  constexpr void (*lists[])(World&) = {list_single,          list_owner,  list_carrier, list_gridpoint,
                                       list_owner_gridpoint, list_moment, list_wrench,  list_pair};
  each_part(w.pool, std::size(lists), 1, [&](size_t list, size_t) { lists[list](w); });
}

}  // namespace quoin::blocks
