// What the ranks that share a model exchange of it.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/broad_phase.h"
#include "model/field.h"

namespace quoin::blocks {

struct World;

struct Items {
  size_t first, end;
};
Items items_of_blocks(const World& w, Owner owner, size_t first_block, size_t end_block);  // in a row

// Motion of blocks close to those of other ranks: at the first time, and where it lies from then on.
void receive_new_neighbours(World& w, const std::vector<geometry::Pair>& pairs);
void bind_neighbours(World& w);
void receive_neighbours(World& w);

}  // namespace quoin::blocks
