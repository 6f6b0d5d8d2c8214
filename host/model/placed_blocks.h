// Corners and faces of blocks in space, for contact detection.
#pragma once

#include "geometry/separation.h"

namespace quoin::blocks {

struct World;

void place_blocks(World& w);  // updates all blocks that are laid out
geometry::Placed placed(const World& w, int block);

}  // namespace quoin::blocks
