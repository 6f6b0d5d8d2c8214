// Transposition between rows of numbers, one a block, and lanes: a line of kLanes for each number. Included once for
// every instruction set.
#if defined(QUOIN_MODEL_TILES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_MODEL_TILES_INL_H
#undef QUOIN_MODEL_TILES_INL_H
#else
#define QUOIN_MODEL_TILES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

// Swaps lanes l, l + kPart of vector i with lanes i, i + kPart of vector l: its own inverse.
#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void transpose_tile(V (&)[kPart]) {}
#else
template <class Tag = D>
HWY_INLINE void transpose_tile(hn::Vec<Tag> (&a)[kPart]) {
  const Tag d;
  if constexpr (kPart == 2) {
    const auto upper = hn::InterleaveUpper(d, a[0], a[1]);
    a[0] = hn::InterleaveLower(d, a[0], a[1]), a[1] = upper;
  } else {
    const auto low01 = hn::InterleaveLower(d, a[0], a[1]), up01 = hn::InterleaveUpper(d, a[0], a[1]);
    const auto low23 = hn::InterleaveLower(d, a[2], a[3]), up23 = hn::InterleaveUpper(d, a[2], a[3]);
    a[0] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(low23), low01);
    a[1] = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(up23), up01);
    a[2] = hn::OddEvenBlocks(low23, hn::SwapAdjacentBlocks(low01));
    a[3] = hn::OddEvenBlocks(up23, hn::SwapAdjacentBlocks(up01));
  }
}
#endif

// rows: kWidth pointers to `count` numbers each, at least kPart; lanes: address of number 0 of the first row.
HWY_INLINE void rows_to_lanes(const double* const* rows, int count, double* lanes) {
  for (int i = 0; i < count; i += kPart) {
    const int at = std::min(i, count - kPart);  // the last tile repeats some numbers
    V tile[kPart];
    for (int l = 0; l < kPart; ++l)
      tile[l] = join(hn::LoadU(Four(), rows[l] + at), hn::LoadU(Four(), rows[l + kWidth - kPart] + at));
    transpose_tile(tile);
    for (int l = 0; l < kPart; ++l) hn::Store(tile[l], D(), lanes + (at + l) * kLanes);
  }
}

// Inverse of rows_to_lanes, for the first `row_count` rows.
HWY_INLINE void lanes_to_rows(const double* lanes, int count, double* const* rows, int row_count) {
  for (int i = 0; i < count; i += kPart) {
    const int at = std::min(i, count - kPart);
    V tile[kPart];
    for (int l = 0; l < kPart; ++l) tile[l] = hn::Load(D(), lanes + (at + l) * kLanes);
    transpose_tile(tile);
    for (int first = 0; first < kWidth; first += kPart) {
      for (int l = 0; l < kPart && first + l < row_count; ++l)
        hn::StoreU(part_of(tile[l], first), Four(), rows[first + l] + at);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#endif
