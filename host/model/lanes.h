// The lane layout of everything that belongs to gridpoints, and the aligned storage under it.
//
// A line holds one gridpoint of 8 blocks: 3 components x 8 lanes = 24 doubles = three cache lines. A gridpoint is named
// by its offset = line * 24 + lane; its component c sits at offset + 8 c. Eight lanes whatever the instruction set: the
// order of every sum, and so every bit, is the same with vectors of 2, 4 or 8.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>

namespace quoin {

inline constexpr int kLanes = 8;
inline constexpr int kLine = 3 * kLanes;  // doubles

template <class T>
struct CacheAligned {
  using value_type = T;
  CacheAligned() = default;
  template <class U>
  CacheAligned(const CacheAligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})); }
  void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
  template <class U>
  bool operator==(const CacheAligned<U>&) const {
    return true;
  }
};

template <class T>
using LaneVector = std::vector<T, CacheAligned<T>>;

}  // namespace quoin
