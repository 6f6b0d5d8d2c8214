// Division of work among ranks and threads, by estimated costs of items and chunks.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "step/results.h"
#include "step/state.h"

namespace quoin {

std::vector<int> rank_by_block(const Simulation::Impl& s);
int item_of_block(const Simulation::Impl& s, int block);  // lattice
// Blocks of an item, and its rigid bodies on the lattice.
std::vector<int> blocks_of_item(const Simulation::Impl& s, int item);
std::vector<int> bodies_of_item(const Simulation::Impl& s, int item);
std::vector<double> estimated_costs(const Simulation::Impl& s);  // by item, its contact points included; any unit
// Share of this rank. In large motion it depends on positions: a model that is not held in parts must be gathered.
RankShare share_of_this_rank(const Simulation::Impl& s);
// Visits the sides of a chunk's contact points: visit(item, key). The key stands for the motion that a side reads
// (borders.cpp).
void each_side(const Simulation::Impl& s, int chunk, const std::function<void(int, std::int64_t)>& visit);
// Visits the items on the sides of a chunk's contact points; the chunk may be of another rank.
void each_item_of_chunk(const Simulation::Impl& s, int chunk, const std::function<void(int)>& visit);
PointRange points_of_chunk(const Simulation::Impl& s, int chunk);  // in either model, over all families
std::vector<int> chunks_here(const Simulation::Impl& s);           // chunks that this process holds
std::vector<int> chunks_with_results(const Simulation::Impl& s);   // all, or own ones where no others are gathered
// Visits the chunks with results whose points are in a range of whole chunks: visit(chunk, points).
template <class Visit>
void each_chunk_in(const Simulation::Impl& s, const PointRange& range, const Visit& visit) {
  for (const int c : chunks_with_results(s)) {
    const PointRange points = points_of_chunk(s, c);
    if (points.first >= range.first && points.end <= range.end) visit(c, points);
  }
}
void partition_work(Simulation::Impl& s);  // divides work; ranks then hold their parts, and halo and threads follow
void divide_work(Simulation::Impl& s);     // computes costs, and the share of this rank

}  // namespace quoin
