// Input and output of a law's kernel: a batch as contiguous columns of doubles, padded to whole vectors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace quoin::shim {

inline constexpr int kMaxStates = 10;
inline constexpr int kMaxPropertyColumns = 24;
// Columns are padded to a multiple of this many points, with copies of the last point. It is the number of doubles in
// the widest vector that kernels use (AVX-512).
inline constexpr std::size_t kMaxLanes = 8;

// Indices into Columns::in; plain integers, since laws add their own column numbers to them. A trailing comment gives
// the number of columns, where there is more than one.
inline constexpr int kNormalJump = 0;
inline constexpr int kSlipIncrement = 1;  // 2
inline constexpr int kTractionOld = 3;    // 3
inline constexpr int kStateOld = 6;       // kMaxStates
inline constexpr int kProperty = kStateOld + kMaxStates;
inline constexpr int kInCount = kProperty + kMaxPropertyColumns;

// Indices into Columns::out. A null pointer there means that the host does not request the output.
inline constexpr int kTractionNew = 0;  // 3
inline constexpr int kStateNew = 3;     // kMaxStates
inline constexpr int kEnergyStored = kStateNew + kMaxStates;
inline constexpr int kDissipated = kEnergyStored + 1;  // 4
inline constexpr int kTangent = kDissipated + 4;       // 9
inline constexpr int kDamage = kTangent + 9;           // 3
inline constexpr int kFlags = kDamage + 3;             // as doubles; plugin.h converts them to integers
inline constexpr int kStatus = kFlags + 1;
inline constexpr int kOutCount = kStatus + 1;

// Pointers to the columns of one call. Entries that the flags exclude are not initialised: that would cost time in
// small batches.
struct Columns {
  const double* in[kInCount];  // those from kProperty on are set only with property_columns
  double* out[kOutCount];      // those from kEnergyStored on are set only with extras
  bool property_columns;       // at least one property is given point by point
  bool extras;                 // property_columns, or outputs beyond tractions and states are requested
  bool more_outputs;           // outputs beyond tractions and states are requested; set only with extras
  bool in_place;               // every new state has the memory of its old state
};

struct Summary {
  std::uint64_t clamped = 0;
  std::uint64_t failed = 0;
  bool yielding = false;
};

}  // namespace quoin::shim
