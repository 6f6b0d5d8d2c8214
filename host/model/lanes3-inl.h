// Vectors and matrices of three dimensions, one a lane; included once for every instruction set.
#if defined(QUOIN_MODEL_LANES3_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_MODEL_LANES3_INL_H
#undef QUOIN_MODEL_LANES3_INL_H
#else
#define QUOIN_MODEL_LANES3_INL_H
#endif

#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

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

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#endif
