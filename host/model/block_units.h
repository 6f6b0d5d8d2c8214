// Deformable blocks that move as halves of one masonry unit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace quoin::blocks {

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
  int count = 0;                    // of two halves that hold together

  enum class Halves : uint8_t { together, also_apart };
  Unit of(int block, Halves halves = Halves::together) const {
    const int other = other_half[size_t(block)];
    if (other < 0 || (halves == Halves::together && apart[size_t(block)])) return {{block, -1}, 1};
    return {{std::min(block, other), std::max(block, other)}, 2};
  }
};

}  // namespace quoin::blocks
