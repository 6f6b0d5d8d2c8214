// Keys of places in masonry, for their random numbers.
#pragma once

#include <cstdint>

#include "scene/scene.h"

namespace quoin {

struct PlacedBlock {
  int unit, course;  // place in the masonry; -1: none
};

// Key of a block: its unit, or a number of its own where it is no part of masonry.
std::uint64_t unit_key(int block, const PlacedBlock& placed);
// Key of the joint between two units.
std::uint64_t joint_key(std::uint64_t unit_a, std::uint64_t unit_b);

// Whether the joint of a family between two blocks lacks mortar in the family's random sample.
bool lacks_mortar(const JointFamily& family, int block_a, const PlacedBlock& a, int block_b, const PlacedBlock& b);

}  // namespace quoin
