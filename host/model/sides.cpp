#include "model/sides.h"

#include <functional>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Lists sides of own blocks.
template <class Side, class Owns, class ForEach>
void by_block(size_t blocks, ByBlock<Side>& sides, Owns owns, ForEach for_each) {
  list_by_block(blocks, sides, [&](const auto& visit) {
    for_each([&](int block, const Side& side) {
      if (owns(block)) visit(block, side);
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
  const auto own = [&](int block) { return w.part.owns(block); };
  const auto each_facet_point = [&](const auto& visit) {  // (point, its first row)
    for (const int c : w.chunks.own) {
      const Chunk& chunk = w.chunks.all[size_t(c)];
      for (const FacetLanes& lanes : chunk.facets) {
        for (uint32_t l = 0; l < lanes.count; ++l)
          visit(w.contacts.families[size_t(chunk.family)].point[lanes.first + l], lanes.row + FacetRow::kCount * l);
      }
    }
  };
  const auto each_gridpoint_pair = [&](const auto& visit) {
    for (const int c : w.chunks.own) {
      for (const GridpointPair& pair : w.chunks.all[size_t(c)].gridpoint_pairs) visit(w.chunks.all[size_t(c)], pair);
    }
  };
  const auto node_of = [&](const Facet& f, int corner, int block) {
    return f.node[corner] - w.blocks[size_t(block)].first_node;
  };
  const std::function<void()> lists[] = {
      [&] {
        by_block(w.blocks.size(), w.sides.single, own, [&](const auto& visit) {
          for (const int c : w.chunks.own) {
            const Chunk& chunk = w.chunks.all[size_t(c)];
            for (const OtherPoint& other : chunk.others) {
              const Point& p = w.contacts.families[size_t(chunk.family)].point[other.index];
              visit(p.a, Touch{&other, chunk.family, true});
              visit(p.b, Touch{&other, chunk.family, false});
            }
          }
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.owner, own, [&](const auto& visit) {
          each_facet_point([&](const Point& p, uint32_t row) {
            const Facet& f = w.contacts.facets[size_t(p.facet_a)];
            visit(p.a, OwnerTouch{row, {node_of(f, 0, p.a), node_of(f, 1, p.a), node_of(f, 2, p.a)}});
          });
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.carrier, own, [&](const auto& visit) {
          each_facet_point([&](const Point& p, uint32_t row) {
            const Facet& f = w.contacts.facets[size_t(p.facet_b)];
            if (sits_on_gridpoint(f)) return;
            visit(p.b, CarrierTouch{row,
                                    {node_of(f, 0, p.b), node_of(f, 1, p.b), node_of(f, 2, p.b)},
                                    {f.weight[0], f.weight[1], f.weight[2]}});
          });
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.gridpoint, own, [&](const auto& visit) {
          each_facet_point([&](const Point& p, uint32_t row) {
            const Facet& f = w.contacts.facets[size_t(p.facet_b)];
            if (sits_on_gridpoint(f)) visit(p.b, GridpointTouch{row, node_of(f, 0, p.b)});
          });
          each_gridpoint_pair([&](const Chunk& chunk, const GridpointPair& pair) {
            const int32_t first = w.blocks[size_t(pair.b)].first_node;
            for (uint32_t k = 0; k < pair.count && !pair.has_body(); ++k)
              visit(pair.b, GridpointTouch{pair.row + k, chunk.node_b[pair.first + k - chunk.first] - first});
          });
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.owner_gridpoint, own, [&](const auto& visit) {
          each_gridpoint_pair([&](const Chunk& chunk, const GridpointPair& pair) {
            const int32_t first = w.blocks[size_t(pair.a)].first_node;
            for (uint32_t k = 0; k < pair.count; ++k)
              visit(pair.a, GridpointTouch{pair.row + k, chunk.node_a[pair.first + k - chunk.first] - first});
          });
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.moment, own, [&](const auto& visit) {
          each_gridpoint_pair([&](const Chunk&, const GridpointPair& pair) { visit(pair.a, pair.sums); });
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.wrench, own, [&](const auto& visit) {
          each_gridpoint_pair([&](const Chunk&, const GridpointPair& pair) {
            if (pair.has_body()) visit(pair.b, pair.sums + 1);
          });
        });
      },
      [&] {
        by_block(w.blocks.size(), w.sides.pair, own, [&](const auto& visit) {
          for (const int c : w.chunks.own) {
            const Chunk& chunk = w.chunks.all[size_t(c)];
            for (const RigidPair& pair : chunk.pairs) {
              const Point& p = w.contacts.families[size_t(chunk.family)].point[pair.first];
              visit(p.a, PairTouch{&pair, true});
              visit(p.b, PairTouch{&pair, false});
            }
          }
        });
      },
  };
  each_part(w.pool, std::size(lists), 1, [&](size_t list, size_t) { lists[list](); });
}

}  // namespace quoin::blocks
