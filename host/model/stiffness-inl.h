// The product with an assembled stiffness, over the blocks in lanes; included once for every instruction set.
#if defined(QUOIN_MODEL_STIFFNESS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_MODEL_STIFFNESS_INL_H
#undef QUOIN_MODEL_STIFFNESS_INL_H
#else
#define QUOIN_MODEL_STIFFNESS_INL_H
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "model/stiffness.h"
#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin {
namespace HWY_NAMESPACE {

// Iterates over the rows of K: next() returns K w of the next gridpoint for kCount groups at once, which share the
// loads of coefficients. For a single group, even and odd columns have separate sums. So there are enough independent
// multiply-adds to hide their latency.
template <int kCount>
struct StiffnessRows {
  explicit StiffnessRows(const Stiffness& k)
      : column(k.column.data()), columns(column), column_end(k.column_end.data()), coefficient(k.coefficient.data()) {}

  HWY_INLINE void next(const double* const (&w)[kCount], V (&f)[kCount][3][kParts]) {
    constexpr int kSums = kCount == 1 ? 2 : 1;
    const D d;
    V sum[kSums][kCount][3][kParts];
    for (auto& of_group : sum) {
      for (auto& of_component : of_group) {
        for (auto& of_part : of_component) {
          for (V& x : of_part) x = hn::Zero(d);
        }
      }
    }
    const auto add = [&](std::int32_t from, const double* k, V(&to)[kCount][3][kParts]) HWY_ATTR {
      V factor[3];
      for (int c = 0; c < 3; ++c) factor[c] = hn::Set(d, k[c]);
      for (int b = 0; b < kCount; ++b) {
        for (int p = 0; p < kParts; ++p) {
          const V x = hn::Load(d, w[b] + from + p * kWidth);
          for (int c = 0; c < 3; ++c) to[b][c][p] = hn::MulAdd(factor[c], x, to[b][c][p]);
        }
      }
    };
    for (const std::int32_t* end = columns + *column_end++; column < end; column += kSums, coefficient += 3 * kSums) {
      for (int i = 0; i < kSums; ++i) add(column[i], coefficient + 3 * i, sum[i]);
    }
    for (int b = 0; b < kCount; ++b) {
      for (int c = 0; c < 3; ++c) {
        for (int p = 0; p < kParts; ++p)
          f[b][c][p] = kSums == 2 ? hn::Add(sum[0][b][c][p], sum[kSums - 1][b][c][p]) : sum[0][b][c][p];
      }
    }
  }

  const std::int32_t* column;
  const std::int32_t* columns;
  const std::int32_t* column_end;
  const double* coefficient;
};

}  // namespace HWY_NAMESPACE
}  // namespace quoin
HWY_AFTER_NAMESPACE();

#endif
