// Division of work: items and chunks of this rank, and each thread's share of them. Written when work is divided. Items
// are unit groups, body groups and lone bodies; or pieces of blocks of any shape.
#pragma once

#include <memory>
#include <vector>

#include "model/model.h"
#include "step/kernels.h"
#include "step/rank_share.h"

namespace quoin {

struct WorkDivision {
  std::vector<double> item_cost, chunk_cost;  // of all ranks, any unit; item_cost excludes contact points
  RankShare share;
  std::vector<int> chunk_order;                      // chunks of `share` in the order in which threads divide them
  std::vector<int> chunk_end, border_end, item_end;  // end of each thread's share in `share`
  std::vector<int> unit_of_group;                    // item of each block group
  std::vector<int> item_by_block;                    // item of each block in large motion; -1: none

  // Memory of threads.
  std::size_t largest_group = 0;                   // size of the largest group of deformable blocks, in doubles
  std::vector<LaneVector<double>> scratch;         // per thread
  std::vector<std::unique_ptr<ChunkJumps>> jumps;  // by thread
  std::vector<Measured> measured;                  // by item, in the last measured step
};

}  // namespace quoin
