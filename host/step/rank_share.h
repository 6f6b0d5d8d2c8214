// What one of several processes does of a step (base/ranks.h). It does whole items and whole chunks, as one process
// alone has them, so that every sum keeps its order and every number its bits.
//
// A rank advances its own items and evaluates all chunks of contact points that touch one of them. Those on a border
// are evaluated on both sides, from the same numbers, so that no forces travel.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "base/rank_rows.h"
#include "model/halo.h"
#include "scene/assembly.h"

namespace quoin {

// Who needs it.
enum class Who {
  everybody,
  first,   // rank 0, for what it writes
  holders  // each rank what it holds: own items, what its chunks touch, what stages watch
};
// A memory of it: first byte, bytes.
using VisitMemory = std::function<void(void*, std::size_t)>;

struct RankShare {
  std::vector<int> chunks;       // chunks of this rank, in order
  std::vector<int> items;        // items of this rank: first those that others wait for, then the rest, each in order
  std::size_t border_items = 0;  // number of items that others wait for

  // Whose values count.
  std::vector<int> rank_of_item, rank_of_chunk;
  std::vector<double> cost_of_rank;  // by which items were dealt out, any unit
  bool owns_item(int item, int rank) const { return rank_of_item[static_cast<std::size_t>(item)] == rank; }
  bool owns_chunk(int chunk, int rank) const { return rank_of_chunk[static_cast<std::size_t>(chunk)] == rank; }
};

// All of it, for one process.
RankShare whole_share(int chunks, int items);

// Recursive coordinate bisection: along the longest side of the box around the places, into parts of equal cost.
// Returns the rank of each. place: m; cost: any unit, > 0. Ties go by index, so that every rank finds the same.
std::vector<int> bisect(const std::vector<Vec3>& place, const std::vector<double>& cost, int ranks);

}  // namespace quoin
