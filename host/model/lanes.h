// Lane layout of all arrays by gridpoint, and the aligned storage under it.
//
// A line holds one gridpoint of 8 blocks: 3 components x 8 lanes = 24 doubles = three cache lines. A gridpoint is named
// by its offset = line * 24 + lane; its component c sits at offset + 8 c. Eight lanes whatever the instruction set: the
// order of every sum, and so every bit, is the same with vectors of 2, 4 or 8.
#pragma once

#include <vector>

#include "base/sparse_memory.h"

namespace quoin {

inline constexpr int kLanes = 8;
inline constexpr int kLine = 3 * kLanes;  // doubles

template <class T>
using LaneVector = std::vector<T, SparseMemory<T>>;

}  // namespace quoin
