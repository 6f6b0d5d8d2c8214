// What a law's kernel sees of a batch: contiguous columns of doubles, padded to whole vectors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace quoin::shim {

inline constexpr int kMaxStates = 8;
inline constexpr int kMaxPropertyColumns = 20;
// Columns are padded to this many points: the widest vector of doubles that kernels may use (AVX-512).
inline constexpr std::size_t kMaxLanes = 8;

// Indices into Columns::in.
enum In : int {
  kNormalJump = 0,
  kSlipIncrement = 1,  // 2
  kTractionOld = 3,    // 3
  kStateOld = 6,       // kMaxStates
  kProperty = kStateOld + kMaxStates,
  kInCount = kProperty + kMaxPropertyColumns
};

// Indices into Columns::out. Null: not wanted.
enum Out : int {
  kTractionNew = 0,  // 3
  kStateNew = 3,     // kMaxStates
  kEnergyStored = kStateNew + kMaxStates,
  kDissipated,                 // 4
  kTangent = kDissipated + 4,  // 9
  kFlags = kTangent + 9,       // as doubles; the shim converts
  kStatus,
  kOutCount
};

struct Columns {
  const double* in[kInCount] = {};
  double* out[kOutCount] = {};
  bool property_columns = false;  // any in[kProperty + k] is given

  // Anything beyond tractions and history: the kernel's full variant is needed.
  bool extras() const {
    for (int k = kEnergyStored; k < kOutCount; ++k) {
      if (out[k] != nullptr) return true;
    }
    return property_columns;
  }
};

struct Summary {
  std::uint64_t clamped = 0;
  std::uint64_t failed = 0;
  bool yielding = false;
};

}  // namespace quoin::shim
