// What is gathered of the other ranks: everything, for a row, or for sums.
#pragma once

#include "step/rank_share.h"
#include "step/state.h"

namespace quoin {

bool has_all(const Simulation::Impl& s);  // whether this process has all results of the last step
// Afterwards they have it as one process alone has it. next: of the shares that holders are to have; null: now.
void gather(Simulation::Impl& s, Part part, Who who = Who::everybody, const RankShare* next = nullptr);
void fetch_for_frame(
    Simulation::Impl& s);  // what results by run, or pieces, show of the blocks of others; or all of it
// What an item, or a chunk, has of it.
void each_memory_of_item(Simulation::Impl& s, Part part, int item, const VisitMemory& visit);
void each_memory_of_chunk(Simulation::Impl& s, Part part, int chunk, const VisitMemory& visit);
void prepare_row(Simulation::Impl& s);  // what a row has of the blocks of this rank

}  // namespace quoin
