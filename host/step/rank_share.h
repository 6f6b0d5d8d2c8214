// Share of one rank in a step (base/ranks.h): whole items and whole chunks, the same as in one process. So every sum
// keeps its order, and results are bitwise identical.
//
// A rank advances its own items and evaluates all chunks of contact points that touch one of them. Chunks at a border
// are evaluated on both sides from the same motion, so no forces are sent.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "base/rank_rows.h"
#include "model/halo.h"
#include "scene/assembly.h"

namespace quoin {

// Ranks that receive gathered data.
enum class Who {
  everybody,
  first,   // rank 0, for the files of results
  holders  // each rank for its part: own items, those that its chunks touch, monitored blocks
};
// visit(first byte, number of bytes) of a contiguous memory.
using VisitMemory = std::function<void(void*, std::size_t)>;

struct RankShare {
  std::vector<int> chunks;       // chunks of this rank, ascending
  std::vector<int> items;        // items of this rank: those at borders, whose motion other ranks read, then the rest
  std::size_t border_items = 0;  // number of items at borders

  // Rank that owns each item and each chunk: its values are gathered.
  std::vector<int> rank_of_item, rank_of_chunk;
  std::vector<double> cost_of_rank;  // estimated cost of each rank's items, any unit
  bool owns_item(int item, int rank) const { return rank_of_item[static_cast<std::size_t>(item)] == rank; }
  bool owns_chunk(int chunk, int rank) const { return rank_of_chunk[static_cast<std::size_t>(chunk)] == rank; }
};

// The share of one process alone: all chunks and items.
RankShare whole_share(int chunks, int items);

// Recursive coordinate bisection: along the longest side of the box around the places, into parts of equal cost.
// Returns the rank of each. place: m; cost: any unit, > 0. Ties are broken by index, so the result is equal on all
// ranks.
std::vector<int> bisect(const std::vector<Vec3>& place, const std::vector<double>& cost, int ranks);

}  // namespace quoin
