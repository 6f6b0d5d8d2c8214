// Corners and faces of blocks in space, as detection reads them.
#pragma once

#include "geometry/separation.h"

namespace quoin::blocks {

struct World;

void place_blocks(World& w);  // that are laid out
geometry::Placed placed(const World& w, int block);

}  // namespace quoin::blocks
