// Who advances which items and evaluates which chunks: the share of this rank, and in it those of the threads. Written
// when work is divided. Items are unit groups, body groups and lone bodies; or pieces of blocks of any shape.
#pragma once

#include <memory>
#include <vector>

#include "model/model.h"
#include "step/kernels.h"
#include "step/rank_share.h"

namespace quoin {

struct WorkDivision {
  std::vector<double> item_cost, chunk_cost;  // costs of all, in any unit; item_cost is without contact points
  RankShare share;
  std::vector<int> chunk_end, border_end, item_end;  // per thread, into those lists
  std::vector<int> unit_of_group;                    // by block group: its item
  std::vector<int> item_by_block;                    // items in large motion

  // What threads work in.
  std::size_t largest_group = 0;            // size of the largest group of deformable blocks, doubles
  std::vector<LaneVector<double>> scratch;  // per thread
  std::vector<std::unique_ptr<ChunkJumps>> jumps;
  std::vector<Measured> measured;  // by item, of the last measured step
};

}  // namespace quoin
