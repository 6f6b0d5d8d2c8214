// Who does what: the shares of ranks and threads, by what items and chunks are estimated to cost.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "step/state.h"

namespace quoin {

std::vector<int> rank_by_block(const Simulation::Impl& s);
int item_of_block(const Simulation::Impl& s, int block);  // item on the lattice
// What an item has: blocks, and of them rigid bodies of the lattice.
std::vector<int> blocks_of_item(const Simulation::Impl& s, int item);
std::vector<int> bodies_of_item(const Simulation::Impl& s, int item);
std::vector<double> estimated_costs(const Simulation::Impl& s);  // by item, its contact points included; any unit
// Share of this rank; in large motion positions count, so all must have been gathered.
RankShare share_of_this_rank(const Simulation::Impl& s);
// Sides of contact points: visit(item, key); numbers_of says where the motion that a key stands for lies.
void each_side(const Simulation::Impl& s, int chunk, const std::function<void(int, std::int64_t)>& visit);
// Items on the sides of its contact points, also of chunks of others.
void each_item_of_chunk(const Simulation::Impl& s, int chunk, const std::function<void(int)>& visit);
std::vector<int> chunks_here(const Simulation::Impl& s);  // chunks that this process holds
void partition_work(Simulation::Impl& s);                 // and all that follows from it
void divide_work(Simulation::Impl& s);                    // costs, and the share of this rank

}  // namespace quoin
