// Vector types and loads of all SIMD kernels; included once for every instruction set.
#if defined(QUOIN_MODEL_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_MODEL_VECTORS_INL_H
#undef QUOIN_MODEL_VECTORS_INL_H
#else
#define QUOIN_MODEL_VECTORS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstdint>

#include "model/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A line of 8 lanes has kParts vectors of kWidth lanes.
using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;
constexpr int kWidth = static_cast<int>(hn::MaxLanes(D()));
constexpr int kParts = kLanes / kWidth;

// The larger of two numbers; NaN once one of them is.
HWY_INLINE V larger_of(V a, V b) { return hn::IfThenElse(hn::Or(hn::Le(b, a), hn::Ne(a, a)), a, b); }

// base[index[i]] for the next lanes of a tag. On AVX2 machines the gather instruction is slower than the loads that it
// stands for. It takes a third of the time of a chunk's jumps on Zen 3. With AVX-512 it is faster.
template <class Tag>
HWY_INLINE hn::Vec<Tag> gather(Tag d, const double* base, const std::int32_t* index) {
#if HWY_TARGET == HWY_AVX2
  if constexpr (hn::MaxLanes(Tag()) == 4) {
    return hn::Vec<Tag>{_mm256_set_pd(base[index[3]], base[index[2]], base[index[1]], base[index[0]])};
  }
#endif
  const hn::Rebind<std::int64_t, Tag> wide;
  const hn::Rebind<std::int32_t, Tag> narrow;
  return hn::GatherIndex(d, base, hn::PromoteTo(wide, hn::LoadU(narrow, index)));
}

// Four consecutive numbers.
constexpr int kFour = 4;
using Four = hn::CappedTag<double, kFour>;
using F = hn::Vec<Four>;
constexpr int kPart = static_cast<int>(hn::MaxLanes(Four()));

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void transpose(const F (&row)[1], F (&column)[1]) { column[0] = row[0]; }
HWY_INLINE V join(F lower, F) { return lower; }
HWY_INLINE F part_of(V v, int) { return v; }
#else
// Templates, so that code without an instruction on a target is not compiled for it.
template <class Tag = Four>
HWY_INLINE void transpose(const hn::Vec<Tag> (&row)[kPart], hn::Vec<Tag> (&column)[kPart]) {
  const Tag d;
  if constexpr (hn::MaxLanes(Tag()) == 2) {
    column[0] = hn::InterleaveLower(d, row[0], row[1]);
    column[1] = hn::InterleaveUpper(d, row[0], row[1]);
  } else {
    const auto low01 = hn::InterleaveLower(d, row[0], row[1]), up01 = hn::InterleaveUpper(d, row[0], row[1]);
    const auto low23 = hn::InterleaveLower(d, row[2], row[3]), up23 = hn::InterleaveUpper(d, row[2], row[3]);
    column[0] = hn::ConcatLowerLower(d, low23, low01);
    column[1] = hn::ConcatLowerLower(d, up23, up01);
    column[2] = hn::ConcatUpperUpper(d, low23, low01);
    column[3] = hn::ConcatUpperUpper(d, up23, up01);
  }
}
template <class Tag = D>
HWY_INLINE hn::Vec<Tag> join(F lower, F upper) {
  if constexpr (hn::MaxLanes(Tag()) == hn::MaxLanes(Four()))
    return lower;
  else
    return hn::Combine(Tag(), upper, lower);
}
template <class Tag = D>
HWY_INLINE F part_of(hn::Vec<Tag> v, int first) {
  if constexpr (hn::MaxLanes(Tag()) == hn::MaxLanes(Four()))
    return v;
  else
    return first == 0 ? hn::LowerHalf(Four(), v) : hn::UpperHalf(Four(), v);
}
#endif

// Four numbers of each lane, from the address row(lane): number i of all lanes in column[i].
template <class Row>
HWY_INLINE void load_rows(const Row& row, V (&column)[kFour]) {
  for (int c = 0; c < kFour; c += kPart) {
    F columns[2][kPart];
    for (int l = 0; l < kWidth; l += kPart) {
      F rows[kPart];
      for (int i = 0; i < kPart; ++i) rows[i] = hn::LoadU(Four(), row(l + i) + c);
      transpose(rows, columns[l / kPart]);
    }
    for (int i = 0; i < kPart; ++i) column[c + i] = join(columns[0][i], columns[1][i]);
  }
}

// Inverse of load_rows: visit(lane, c, numbers c .. c + kPart - 1 of that lane), for the first `count` lanes.
template <class Visit>
HWY_INLINE void for_rows(const V (&column)[kFour], int count, const Visit& visit) {
  for (int c = 0; c < kFour; c += kPart) {
    for (int l = 0; l < std::min(kWidth, count); l += kPart) {
      F columns[kPart], rows[kPart];
      for (int i = 0; i < kPart; ++i) columns[i] = part_of(column[c + i], l);
      transpose(columns, rows);
      for (int i = 0; i < kPart && l + i < count; ++i) visit(l + i, c, rows[i]);
    }
  }
}

// Fd = gamma |F| sgn(v) of equation 1; sgn(0) = 0, so that mirrored motion from rest has mirrored forces.
HWY_INLINE V local_damping(V gamma, V force, V velocity) {
  const V amount = hn::CopySign(hn::Mul(gamma, hn::Abs(force)), velocity);
  return hn::IfThenZeroElse(hn::Eq(velocity, hn::Zero(D())), amount);
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#endif
