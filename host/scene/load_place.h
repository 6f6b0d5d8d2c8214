// Places where external loads act on blocks.
#pragma once

#include <vector>

#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin::blocks {

struct LoadPlace {
  int block = -1;
  geometry::Vector position, at;  // position on the line of the load, and place on the block, at the start, m
};

// Place for each position of the load: on the first face on the force's line of action, or in the block that contains
// the position. Throws Error(bad_input), with the place in the scene, for a position without a block on its line of
// action.
std::vector<LoadPlace> places_of(const MovingLoad& load, const Assembly& assembly, const std::string& where);

// Distance of a point from a block at the start, m; not above 0 inside.
double distance_from(const Assembly& assembly, const Block& block, const geometry::Vector& point);

}  // namespace quoin::blocks
