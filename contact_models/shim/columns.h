// What a law's kernel sees of a batch: contiguous columns of doubles, padded to whole vectors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace quoin::shim {

inline constexpr int kMaxStates = 8;
inline constexpr int kMaxPropertyColumns = 20;
// Columns are padded to this many points: the widest vector of doubles that kernels may use (AVX-512).
inline constexpr std::size_t kMaxLanes = 8;

// Indices into Columns::in; plain integers, since laws add their own column numbers to them.
inline constexpr int kNormalJump = 0;
inline constexpr int kSlipIncrement = 1;  // 2
inline constexpr int kTractionOld = 3;    // 3
inline constexpr int kStateOld = 6;       // kMaxStates
inline constexpr int kProperty = kStateOld + kMaxStates;
inline constexpr int kInCount = kProperty + kMaxPropertyColumns;

// Indices into Columns::out. Null: not wanted.
inline constexpr int kTractionNew = 0;  // 3
inline constexpr int kStateNew = 3;     // kMaxStates
inline constexpr int kEnergyStored = kStateNew + kMaxStates;
inline constexpr int kDissipated = kEnergyStored + 1;  // 4
inline constexpr int kTangent = kDissipated + 4;       // 9
inline constexpr int kFlags = kTangent + 9;            // as doubles; the shim converts
inline constexpr int kStatus = kFlags + 1;
inline constexpr int kOutCount = kStatus + 1;

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
