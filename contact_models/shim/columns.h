// The form in which a law's kernel gets a batch: contiguous columns of doubles, padded to whole vectors.
#pragma once

#include <cstddef>
#include <cstdint>

namespace quoin::shim {

inline constexpr int kMaxStates = 10;
inline constexpr int kMaxPropertyColumns = 24;
// Columns are padded to this many points, with copies of the last one: the widest vector of doubles that kernels may
// use (AVX-512).
inline constexpr std::size_t kMaxLanes = 8;

// Indices into Columns::in; plain integers, since laws add their own column numbers to them.
inline constexpr int kNormalJump = 0;
inline constexpr int kSlipIncrement = 1;  // 2
inline constexpr int kTractionOld = 3;    // 3
inline constexpr int kStateOld = 6;       // kMaxStates
inline constexpr int kProperty = kStateOld + kMaxStates;
inline constexpr int kInCount = kProperty + kMaxPropertyColumns;

// Indices into Columns::out. Null: not requested.
inline constexpr int kTractionNew = 0;  // 3
inline constexpr int kStateNew = 3;     // kMaxStates
inline constexpr int kEnergyStored = kStateNew + kMaxStates;
inline constexpr int kDissipated = kEnergyStored + 1;  // 4
inline constexpr int kTangent = kDissipated + 4;       // 9
inline constexpr int kDamage = kTangent + 9;           // 3
inline constexpr int kFlags = kDamage + 3;             // as doubles; the shim converts
inline constexpr int kStatus = kFlags + 1;
inline constexpr int kOutCount = kStatus + 1;

// Filled in by the shim at every call, and no more of it than is needed: it costs time in small batches.
struct Columns {
  const double* in[kInCount];  // from kProperty on only with property_columns
  double* out[kOutCount];      // from kEnergyStored on only with extras
  bool property_columns;       // some property is given point by point
  bool extras;                 // that, or anything beyond tractions and history is requested
  bool more_outputs;           // anything beyond tractions and history is requested; set with extras alone
  bool in_place;               // every new state is its old one, in the same memory
};

struct Summary {
  std::uint64_t clamped = 0;
  std::uint64_t failed = 0;
  bool yielding = false;
};

}  // namespace quoin::shim
