// What the ranks that share a model exchange of it.
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
Items items_of_blocks(const World& w, Owner owner, size_t first_block, size_t end_block);  // in a row

// All ranks have the outline of the model: blocks, pairs that are close, how many contact points they have. Arrays have
// the numbers of the whole model; laid out, and in memory, is what a rank works with. It is its own blocks, the chunks
// of points that touch them, and what those and close pairs touch of others.
// Blocks go to these ranks from now on. known: blocks that every rank is to have besides.
void hold_blocks(World& w, std::vector<int> rank_of_block, std::span<const int> known);
void exchange_blocks(World& w, std::span<const int> chosen);     // to all
void exchange_joints(World& w, std::span<const int> of_blocks);  // to all: their contact points, and what these touch
void exchange_parted_blocks(World& w);                           // by all ranks at the same moment
size_t gather_everything(World& w, bool to_all);                 // or to rank 0 alone; bytes
// visit(rank, first byte, bytes): what steps change of blocks and points, by the rank that has it.
using VisitOwned = std::function<void(int, void*, size_t)>;
void each_owned_memory(World& w, const VisitOwned& visit);

// Motion of blocks close to those of other ranks: at the first time, and where it lies from then on.
void receive_new_neighbours(World& w, const std::vector<geometry::Pair>& pairs);
void bind_neighbours(World& w);
void receive_neighbours(World& w);

}  // namespace quoin::blocks
