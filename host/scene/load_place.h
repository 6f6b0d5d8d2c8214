// Where loads that come from outside meet blocks.
#pragma once

#include <vector>

#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin::blocks {

struct LoadPlace {
  int block = -1;
  geometry::Vector position, at;  // places on the line of the load, and on the block at the start, m
};

// By position: the first face that the line of action of the force meets from there on, or the block that has the
// position. Throws Error(bad_input) with places for a position from which it meets none.
std::vector<LoadPlace> places_of(const MovingLoad& load, const Assembly& assembly, const std::string& where);

}  // namespace quoin::blocks
