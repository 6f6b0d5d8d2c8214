// Vector helpers shared by the kernels. Included inside HWY_NAMESPACE once for every instruction set, so without a
// pragma once: the guard toggles as Highway requires.
#if defined(QUOIN_SHIM_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_LANES_H
#undef QUOIN_SHIM_LANES_H
#else
#define QUOIN_SHIM_LANES_H
#endif

#include "hwy/highway.h"
#include "shim/columns.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, kMaxLanes>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

HWY_INLINE V zero() { return hn::Zero(D()); }
HWY_INLINE V splat(double value) { return hn::Set(D(), value); }
HWY_INLINE V select(M mask, V yes, V no) { return hn::IfThenElse(mask, yes, no); }
HWY_INLINE V positive_part(V x) { return hn::Max(x, zero()); }
HWY_INLINE bool none(M mask) { return hn::AllFalse(D(), mask); }
HWY_INLINE bool all(M mask) { return hn::AllTrue(D(), mask); }
HWY_INLINE V load(const double* column, std::size_t i) { return hn::LoadU(D(), column + i); }
HWY_INLINE void store(V value, double* column, std::size_t i) { hn::StoreU(value, D(), column + i); }

// Access of a kernel to its columns. Vectors: one point a lane. OnePoint: the single point of a call, copied to every
// lane; its result is written from the first lane.
struct Vectors {
  static constexpr bool kOnePoint = false;
  static HWY_INLINE V load(const double* column, std::size_t i) { return hn::LoadU(D(), column + i); }
  static HWY_INLINE void store(V value, double* column, std::size_t i) { hn::StoreU(value, D(), column + i); }
};
struct OnePoint {
  static constexpr bool kOnePoint = true;
  static HWY_INLINE V load(const double* column, std::size_t) { return hn::Set(D(), *column); }
  static HWY_INLINE void store(V value, double* column, std::size_t) { *column = hn::GetLane(value); }
};

HWY_INLINE V flag_if(M mask, std::uint32_t bit) { return hn::IfThenElseZero(mask, splat(static_cast<double>(bit))); }

// Adds x * 0 to collected, which stays 0 while every x is finite and becomes NaN otherwise: one register for a test of
// many values.
HWY_INLINE V gather_non_finite(V x, V collected) { return hn::MulAdd(x, zero(), collected); }
HWY_INLINE M is_finite(V collected) { return hn::Eq(collected, zero()); }

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
