// The loops over the vectors of a batch, for laws with a short path. A law's kernel gives, in the namespace of its Law,
//   template <class Access> bool step_elastic(const Law&, const Columns&, std::size_t i);
//     the points from i on, when nothing moves them but elastically and nothing else is asked of: false, and nothing
//     written, when there is one for which this is not sure
//   auto short_path(const Law&);
//     what step_elastic is given for a Law in a loop: the law, or the few of its numbers that it reads
//   template <bool kFull, class Access>
//   void step_vector(const Law&, const Columns&, std::size_t i, std::size_t count, Summary&);
//     the points from i on that fill a vector, through the whole step; count: of all points, the last vector may not be
//     full: it then ends with copies of the last point
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

// What is to be done before a vector goes through the whole step: nothing, where every point has the same properties.
struct Unprepared {
  HWY_INLINE void operator()(std::size_t) const {}
};

// The vectors that begin at starts[0] ... starts[n - 1], back to back: the roots and divisions of one overlap with the
// next one's. Out of line, so that the short path keeps its registers.
template <bool kFull, class Law, class Prepare>
HWY_NOINLINE void step_vectors(const Law& law, const Columns& c, const std::size_t* starts, std::size_t n,
                               std::size_t count, const Prepare& prepare, Summary& summary) {
  for (std::size_t k = 0; k < n; ++k) {
    prepare(starts[k]);
    step_vector<kFull, Vectors>(law, c, starts[k], count, summary);
  }
}

// First all vectors of a tile that are elastic, then the others. A tile's columns fit into the first cache.
inline constexpr std::size_t kLoopTile = 256;

// Tractions and states only. elastic(i) takes the short path for the points from i on, as step_elastic does. For those
// from i on that take the whole step prepare(i) comes first.
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
  // Copies, so that the short path keeps them in registers: what is stored might change c and the law.
  const Columns own = c;
  const auto& quick = short_path(law);
  const auto elastic = [&](std::size_t i) HWY_ATTR { return step_elastic<Vectors>(quick, own, i); };
  run_lean(law, c, count, elastic, Unprepared(), summary);
}

// Whatever outputs are requested. prepare(i) before the points from i on: their properties.
template <class Law, class Prepare>
HWY_INLINE void run_full(const Law& law, const Columns& c, std::size_t count, Summary& summary,
                         const Prepare& prepare) {
  for (std::size_t i = 0; i < count; i += hn::Lanes(D())) {
    prepare(i);
    step_vectors<true>(law, c, &i, 1, count, Unprepared(), summary);
  }
}

// A call of one point: the same vectors with this point in every lane, and so the same bits.
template <class Law>
HWY_INLINE void run_one(const Law& law, const Columns& c, std::size_t count, Summary& summary) {
  if (!step_elastic<OnePoint>(short_path(law), c, 0)) step_vector<false, OnePoint>(law, c, 0, count, summary);
}

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
