// The softening function f(xi) in its three shapes: fracture_energy/LAW.md, "Softening function". Each shape has
//   factor(xi)       f
//   slope(xi)        f', from the right
//   drop(a, b)       f(a) - f(b), without cancellation for close a and b
//   area(a, b)       integral of f from a to b
#if defined(QUOIN_SHIM_SOFTENING_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_SOFTENING_H
#undef QUOIN_SHIM_SOFTENING_H
#else
#define QUOIN_SHIM_SOFTENING_H
#endif

#include "hwy/contrib/math/math-inl.h"
#include "shim/lanes.h"
#include "shim/softening_shape.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

struct LinearSoftening {
  static constexpr Shape kShape = Shape::linear;
  explicit LinearSoftening(const SofteningShape&) {}

  HWY_INLINE V factor(V xi) const { return positive_part(hn::Sub(splat(1.0), xi)); }
  HWY_INLINE V slope(V xi) const { return hn::IfThenElseZero(hn::Lt(xi, splat(1.0)), splat(-1.0)); }
  HWY_INLINE V drop(V a, V b) const { return hn::Sub(hn::Min(b, splat(1.0)), hn::Min(a, splat(1.0))); }
  HWY_INLINE V area(V a, V b) const {
    const V mean = hn::Mul(splat(0.5), hn::Add(hn::Min(a, splat(1.0)), hn::Min(b, splat(1.0))));
    return hn::Mul(drop(a, b), hn::Sub(splat(1.0), mean));
  }
};

struct ExponentialSoftening {
  static constexpr Shape kShape = Shape::exponential;
  explicit ExponentialSoftening(const SofteningShape&) {}

  HWY_INLINE V factor(V xi) const {
    if (all(hn::Eq(xi, zero()))) return splat(1.0);  // the most common case: undamaged joints
    const V f = hn::Exp(D(), hn::Neg(hn::Min(xi, splat(kExponentialEnd))));
    return hn::IfThenElseZero(hn::Lt(xi, splat(kExponentialEnd)), f);
  }
  HWY_INLINE V slope(V xi) const { return hn::Neg(factor(xi)); }
  HWY_INLINE V drop(V a, V b) const {
    const V step = hn::Min(hn::Sub(b, a), splat(kExponentialEnd));
    return hn::Mul(hn::Neg(factor(a)), hn::Expm1(D(), hn::Neg(step)));
  }
  HWY_INLINE V area(V a, V b) const { return drop(a, b); }
};

struct TableSoftening {
  static constexpr Shape kShape = Shape::table;
  explicit TableSoftening(const SofteningShape& material) : table(material.table) {}
  const SofteningTable& table;

  // Segment of the table that contains xi. x: its start; f: factor there; slope: f' of the segment; area: integral of f
  // from 0 to x. Beyond the last point f and slope are 0.
  struct Segment {
    V x, f, slope, area;
  };
  HWY_INLINE Segment segment(V xi) const {
    Segment s{zero(), zero(), zero(), zero()};
    for (int k = 0; k < table.points; ++k) {
      const M inside = hn::Ge(xi, splat(table.x[k]));
      const bool last = k + 1 == table.points;
      const double fall = last ? 0.0 : (table.f[k + 1] - table.f[k]) / (table.x[k + 1] - table.x[k]);
      s.x = select(inside, splat(table.x[k]), s.x);
      s.f = select(inside, splat(table.f[k]), s.f);
      s.slope = select(inside, splat(fall), s.slope);
      s.area = select(inside, splat(table.area[k]), s.area);
    }
    return s;
  }
  HWY_INLINE V factor(V xi) const {
    const Segment s = segment(xi);
    return positive_part(hn::MulAdd(s.slope, hn::Sub(xi, s.x), s.f));
  }
  HWY_INLINE V slope(V xi) const { return segment(xi).slope; }
  HWY_INLINE V drop(V a, V b) const {
    const Segment s = segment(a), e = segment(b);
    const V within = hn::Mul(s.slope, hn::Sub(a, b));
    const V across = hn::Sub(factor(a), factor(b));
    return positive_part(select(hn::Eq(s.x, e.x), within, across));
  }
  HWY_INLINE V area(V a, V b) const {
    const Segment s = segment(a), e = segment(b);
    const V half = splat(0.5);
    // A step within one segment is one trapezoid, without cancellation. A step across segments is a difference of
    // areas.
    const V within = hn::Mul(hn::Sub(b, a), hn::Mul(half, hn::Add(factor(a), factor(b))));
    const V from_a = hn::Mul(hn::Sub(a, s.x), hn::Mul(half, hn::Add(s.f, factor(a))));
    const V to_b = hn::Mul(hn::Sub(b, e.x), hn::Mul(half, hn::Add(e.f, factor(b))));
    const V across = hn::Sub(hn::Add(e.area, to_b), hn::Add(s.area, from_a));
    return positive_part(select(hn::Eq(s.x, e.x), within, across));
  }
};

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
