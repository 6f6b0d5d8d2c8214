// Deformable blocks that move as halves of one masonry unit.
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

// Deformable blocks that move on together: one, or the two halves of a masonry unit.
struct Unit {
  int block[2] = {-1, -1};
  int count = 1;
  std::span<const int> blocks() const { return {block, size_t(count)}; }
  bool has(int i) const { return i == block[0] || (count == 2 && i == block[1]); }
};

// Found at the start; steps part halves that nothing holds together, and join them again.
struct Units {
  std::vector<int32_t> other_half;  // by block; -1: none
  std::vector<uint8_t> apart;       // by block: nothing holds it and its other half together
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
// By the first half or single block; others: nothing.
std::vector<UnitInertia> inertia_of_units(const World& w, std::span<const int> blocks);
void scale_motion(const World& w, std::span<const int> blocks, const std::vector<UnitInertia>& inertias,
                  LaneVector<geometry::Vector>& y, bool of_forces);
void part_units(World& w);

}  // namespace quoin::blocks
