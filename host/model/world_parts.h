// Exchange of blocks and contact points between ranks that share a model.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "geometry/broad_phase.h"
#include "model/field.h"

namespace quoin::blocks {

struct World;

struct Items {
  size_t first, end;
};
Items items_of_blocks(const World& w, Owner owner, size_t first_block, size_t end_block);  // of consecutive blocks

// All ranks have the outline of the model: blocks, pairs that are close, and numbers of contact points. Arrays have the
// length of the whole model. A rank lays out its own blocks, the chunks of points that touch them, and the blocks of
// these chunks and of close pairs.
//
// Assigns blocks to these ranks. known: blocks that every rank has besides its own.
void hold_blocks(World& w, std::vector<int> rank_of_block, std::span<const int> known);
// Send to all ranks: these blocks; contact points of these blocks, with the blocks that they touch.
void exchange_blocks(World& w, std::span<const int> chosen);
void exchange_joints(World& w, std::span<const int> of_blocks);
void exchange_parted_blocks(World& w);  // collective
// Sends blocks with a number other than 0 to the ranks that have laid them out. Collective.
void refresh_blocks(World& w, std::span<const double> chosen);
size_t gather_everything(World& w, bool to_all);  // or to rank 0 alone; returns bytes
// visit(rank, first byte, bytes): data of blocks and points that steps change, with the rank that owns them.
using VisitOwned = std::function<void(int, void*, size_t)>;
void each_owned_memory(World& w, const VisitOwned& visit);

// Receives blocks close to those of this rank for the first time; binds addresses of their motion for later exchanges.
void receive_new_neighbours(World& w, const std::vector<geometry::Pair>& pairs);
void bind_neighbours(World& w);
void receive_neighbours(World& w);

}  // namespace quoin::blocks
