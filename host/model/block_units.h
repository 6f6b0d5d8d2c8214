// Deformable blocks that are halves of one masonry unit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "model/block_inertia.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

// Deformable blocks that are advanced together: a single block, or the two halves of a masonry unit.
struct Unit {
  int block[2] = {-1, -1};
  int count = 1;
  std::span<const int> blocks() const { return {block, size_t(count)}; }
  bool has(int i) const { return i == block[0] || (count == 2 && i == block[1]); }
};

// Units are found at the start. Steps separate halves that nothing holds together, and join them again.
struct Units {
  std::vector<int32_t> other_half;  // by block; -1: the block is no half
  std::vector<uint8_t> apart;       // by block: 1 where nothing holds it and its other half together
  std::vector<size_t> joint;        // by first half: index of the halves' joint in Contacts::list at the last search
  int count = 0;                    // number of units of two halves that hold together

  enum class Halves : uint8_t { together, also_apart };
  Unit of(int block, Halves halves = Halves::together) const {
    const int other = other_half[size_t(block)];
    if (other < 0 || (halves == Halves::together && apart[size_t(block)])) return {{block, -1}, 1};
    return {{std::min(block, other), std::max(block, other)}, 2};
  }
};

void find_units(World& w);
double rigid_kinetic_energy(const World& w, const Unit& unit);
// Inertia of the units of these blocks, at the index of the single block or of the first half; others are empty.
std::vector<UnitInertia> inertia_of_units(const World& w, std::span<const int> blocks);
void scale_motion(const World& w, std::span<const int> blocks, const std::vector<UnitInertia>& inertias,
                  LaneVector<geometry::Vector>& y, bool of_forces);
void part_units(World& w);

}  // namespace quoin::blocks
