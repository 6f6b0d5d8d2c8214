// Loops over the vectors of a batch, for laws with a short path. A law's kernel defines, in the namespace of its Law,
//   template <class Access> bool step_elastic(const Law&, const Columns&, std::size_t i);
//     Short path: computes tractions and states of the vector of points from i on if all of them are elastic. Returns
//     false, and writes nothing, if a point may yield.
//   auto short_path(const Law&);
//     Returns the first argument of step_elastic in a loop: the law, or the few of its numbers that step_elastic reads.
//   template <bool kFull, class Access>
//   void step_vector(const Law&, const Columns&, std::size_t i, std::size_t count, Summary&);
//     Whole step of the vector of points from i on. count is the number of points of the batch; a last vector that is
//     not full ends with copies of the last point.
#if defined(QUOIN_SHIM_LOOP_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_LOOP_H
#undef QUOIN_SHIM_LOOP_H
#else
#define QUOIN_SHIM_LOOP_H
#endif

#include <algorithm>

#include "shim/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

// Preparation of a vector before its whole step where every point has the same properties: none.
struct Unprepared {
  HWY_INLINE void operator()(std::size_t) const {}
};

// Computes the whole step of the vectors that begin at starts[0] ... starts[n - 1]. One directly after the other, so
// that the processor overlaps their square roots and divisions. Out of line: the short path keeps its registers.
template <bool kFull, class Law, class Prepare>
HWY_NOINLINE void step_vectors(const Law& law, const Columns& c, const std::size_t* starts, std::size_t n,
                               std::size_t count, const Prepare& prepare, Summary& summary) {
  for (std::size_t k = 0; k < n; ++k) {
    prepare(starts[k]);
    step_vector<kFull, Vectors>(law, c, starts[k], count, summary);
  }
}

// Points of a tile: run_lean computes its elastic vectors first, then the others. A tile's columns fit into the L1
// cache.
inline constexpr std::size_t kLoopTile = 256;

// Computes tractions and states only. elastic(i) computes the vector from i on by the short path and returns what
// step_elastic returns. prepare(i) is called before the whole step of the vector from i on.
template <class Law, class Elastic, class Prepare>
HWY_INLINE void run_lean(const Law& law, const Columns& c, std::size_t count, const Elastic& elastic,
                         const Prepare& prepare, Summary& summary) {
  std::size_t rest[kLoopTile];
  for (std::size_t i = 0; i < count;) {
    const std::size_t end = std::min(count, i + kLoopTile);
    std::size_t n = 0;
    for (; i < end; i += hn::Lanes(D())) {
      if (!elastic(i)) rest[n++] = i;
    }
    if (n > 0) step_vectors<false>(law, c, rest, n, count, prepare, summary);
  }
}
template <class Law>
HWY_INLINE void run_lean(const Law& law, const Columns& c, std::size_t count, Summary& summary) {
  // Copies, which the compiler keeps in registers: it must assume that a store changes c and the law.
  const Columns own = c;
  const auto& quick = short_path(law);
  const auto elastic = [&](std::size_t i) HWY_ATTR { return step_elastic<Vectors>(quick, own, i); };
  run_lean(law, c, count, elastic, Unprepared(), summary);
}

// Computes all outputs that are requested. prepare(i) sets the properties of the vector from i on.
template <class Law, class Prepare>
HWY_INLINE void run_full(const Law& law, const Columns& c, std::size_t count, Summary& summary,
                         const Prepare& prepare) {
  for (std::size_t i = 0; i < count; i += hn::Lanes(D())) {
    prepare(i);
    step_vectors<true>(law, c, &i, 1, count, Unprepared(), summary);
  }
}

// Computes a batch of one point, with this point in every lane: bitwise identical to the point in a larger batch.
template <class Law>
HWY_INLINE void run_one(const Law& law, const Columns& c, std::size_t count, Summary& summary) {
  if (!step_elastic<OnePoint>(short_path(law), c, 0)) step_vector<false, OnePoint>(law, c, 0, count, summary);
}

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
