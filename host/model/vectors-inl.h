// Vector types and loads of all SIMD kernels, and vectors in space, one a lane; included once for every instruction
// set.
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

// visit(i, load, store) for numbers i, i + 1, ... of columns, from `first` on, a vector at a time. Lanes from `end` on
// are loaded as 0 and not stored.
template <class Tag, class Visit>
HWY_INLINE void for_each_vector(Tag d, std::size_t first, std::size_t end, const Visit& visit) {
  std::size_t i = first;
  for (; i + hn::MaxLanes(Tag()) <= end; i += hn::MaxLanes(Tag())) {
    visit(
        i, [&](const double* from) HWY_ATTR { return hn::LoadU(d, from + i); },
        [&](hn::Vec<Tag> x, double* to) HWY_ATTR { hn::StoreU(x, d, to + i); });
  }
  if (i >= end) return;
  const auto rest = hn::FirstN(d, end - i);
  visit(
      i, [&](const double* from) HWY_ATTR { return hn::MaskedLoad(rest, d, from + i); },
      [&](hn::Vec<Tag> x, double* to) HWY_ATTR { hn::BlendedStore(x, rest, d, to + i); });
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

// ---- Vectors and matrices of three dimensions, one a lane ----------------------------------------------------------

struct Lanes3 {
  V x, y, z;
  HWY_INLINE V& operator[](int k) { return k == 0 ? x : (k == 1 ? y : z); }
  HWY_INLINE const V& operator[](int k) const { return k == 0 ? x : (k == 1 ? y : z); }
};
struct Lanes33 {
  Lanes3 row[3];
};

HWY_INLINE V twice(V a) { return hn::Add(a, a); }
HWY_INLINE Lanes3 cross_of(const Lanes3& a, const Lanes3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)),
          hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE V dot_of(const Lanes3& a, const Lanes3& b) {
  return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z)));
}
HWY_INLINE Lanes3 scaled(V f, const Lanes3& a) { return {hn::Mul(f, a.x), hn::Mul(f, a.y), hn::Mul(f, a.z)}; }
HWY_INLINE Lanes3 sum_of(const Lanes3& a, const Lanes3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Lanes3 times(const Lanes33& m, const Lanes3& v) {
  return {dot_of(m.row[0], v), dot_of(m.row[1], v), dot_of(m.row[2], v)};
}
HWY_INLINE Lanes3 transposed_times_of(const Lanes33& m, const Lanes3& v) {
  return sum_of(scaled(v.x, m.row[0]), sum_of(scaled(v.y, m.row[1]), scaled(v.z, m.row[2])));
}
HWY_INLINE Lanes3 difference_of(const Lanes3& a, const Lanes3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
// a + f b
HWY_INLINE Lanes3 plus_scaled(const Lanes3& a, V f, const Lanes3& b) {
  return {hn::MulAdd(f, b.x, a.x), hn::MulAdd(f, b.y, a.y), hn::MulAdd(f, b.z, a.z)};
}
HWY_INLINE Lanes3 zeros() { return {hn::Zero(D()), hn::Zero(D()), hn::Zero(D())}; }
HWY_INLINE Lanes3 broadcast(const double* of) {
  return {hn::Set(D(), of[0]), hn::Set(D(), of[1]), hn::Set(D(), of[2])};
}
// A column of a line: its three components, kLanes apart.
HWY_INLINE Lanes3 load_line(const double* line) {
  return {hn::Load(D(), line), hn::Load(D(), line + kLanes), hn::Load(D(), line + 2 * kLanes)};
}
HWY_INLINE void store_line(const Lanes3& a, double* line) {
  for (int c = 0; c < 3; ++c) hn::Store(a[c], D(), line + c * kLanes);
}
// Numbers c .. 2 of the three at `from`; memory beyond them is not read.
HWY_INLINE F part_of_vector(const double* from, int c) {
  if constexpr (kPart == 4)
    return hn::MaskedLoad(hn::FirstN(Four(), 3), Four(), from);
  else
    return c + kPart <= 3 ? hn::LoadU(Four(), from + c) : hn::Set(Four(), from[c]);
}

// Three numbers of each lane, from the address row(lane).
template <class Row>
HWY_INLINE Lanes3 load_vectors(const Row& row) {
  Lanes3 vectors;
  for (int c = 0; c < 3; c += kPart) {
    F columns[2][kPart];
    for (int l = 0; l < kWidth; l += kPart) {
      F rows[kPart];
      for (int i = 0; i < kPart; ++i) rows[i] = part_of_vector(row(l + i), c);
      transpose(rows, columns[l / kPart]);
    }
    for (int i = 0; i < kPart && c + i < 3; ++i) vectors[c + i] = join(columns[0][i], columns[1][i]);
  }
  return vectors;
}

// The first `count` numbers of a vector; the others are read as 0 and not written.
struct FirstLanes {
  int count;
  HWY_INLINE V load(const double* from) const {
    if (count >= kWidth) return hn::LoadU(D(), from);
    return hn::MaskedLoad(hn::FirstN(D(), static_cast<std::size_t>(count)), D(), from);
  }
  HWY_INLINE void store(V v, double* to) const {
    if (count >= kWidth) return hn::StoreU(v, D(), to);
    hn::BlendedStore(v, hn::FirstN(D(), static_cast<std::size_t>(count)), D(), to);
  }
};

// Cofactors, row by row; the determinant is the scalar product of row[0] of both matrices.
HWY_INLINE Lanes33 cofactors_of(const Lanes33& m) {
  return {{cross_of(m.row[1], m.row[2]), cross_of(m.row[2], m.row[0]), cross_of(m.row[0], m.row[1])}};
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
