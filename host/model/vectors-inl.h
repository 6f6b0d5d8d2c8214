// The vectors that all kernels over lanes compute with; included once for every instruction set.
#if defined(QUOIN_MODEL_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_MODEL_VECTORS_INL_H
#undef QUOIN_MODEL_VECTORS_INL_H
#else
#define QUOIN_MODEL_VECTORS_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "model/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A line of 8 lanes is kParts vectors of kWidth.
using D = hn::CappedTag<double, kLanes>;
using V = hn::Vec<D>;
constexpr int kWidth = static_cast<int>(hn::MaxLanes(D()));
constexpr int kParts = kLanes / kWidth;

// base[index[i]] for the next lanes of a tag. On AVX2 machines the gather instruction is slower than the loads that it
// stands for (a third of the time of a chunk's jumps on Zen 3), with AVX-512 it is faster.
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

// Fd = gamma |F| sgn(v) of equation 1, sgn(0) = +1.
HWY_INLINE V local_damping(V gamma, V force, V velocity) {
  const V amount = hn::Mul(gamma, hn::Abs(force));
  return hn::IfThenElse(hn::Lt(velocity, hn::Zero(D())), hn::Neg(amount), amount);
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#endif
