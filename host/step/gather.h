// Gathering of other ranks' data: all of it, the numbers of a row, or sums.
#pragma once

#include "step/rank_share.h"
#include "step/state.h"

namespace quoin {

bool has_all(const Simulation::Impl& s);  // whether this process holds all results of the last step
// Gathers a part of the model's state on the ranks that `who` names. next: shares that decide what holders receive;
// null: the current ones.
void gather(Simulation::Impl& s, Part part, Who who = Who::everybody, const RankShare* next = nullptr);
// Fetches what a frame shows of other ranks' blocks: data at borders where results are collected by run or written in
// pieces, else all data.
void fetch_for_frame(Simulation::Impl& s);
// Visit the memory of an item, or of a chunk, that belongs to a part of the state.
void each_memory_of_item(Simulation::Impl& s, Part part, int item, const VisitMemory& visit);
void each_memory_of_chunk(Simulation::Impl& s, Part part, int chunk, const VisitMemory& visit);
void prepare_row(Simulation::Impl& s);  // computes the numbers of a row for the blocks of this rank
// Transfers an array, whose parts ranks hold, to rank 0, some megabytes at a time. whole: its size, bytes. take: called
// on rank 0 with pieces of the array, in order.
void give_array(Simulation::Impl& s, const void* array, std::size_t whole, const Simulation::TakeBytes& take);

}  // namespace quoin
