#include "step/point_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "step/point_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::blocks {
namespace HWY_NAMESPACE {
using namespace quoin::HWY_NAMESPACE;

// Sums in eight lanes.
struct LaneSum {
  V part[kParts];

  HWY_INLINE LaneSum() {
    for (V& p : part) p = hn::Zero(D());
  }
  HWY_INLINE double total() const {
    alignas(64) double lane[kLanes];
    for (int p = 0; p < kParts; ++p) hn::Store(part[p], D(), lane + p * kWidth);
    double sum = 0.0;
    for (const double x : lane) sum += x;
    return sum;
  }
};

HWY_INLINE std::size_t part_of_sum(std::size_t i) { return i / static_cast<std::size_t>(kWidth) % kParts; }

// A joint slides or softens where its secant stiffness is below the share kLettingGo of its elastic stiffness. Changes
// of the traction by less than the share kRounding of it are rounding.
constexpr double kLettingGo = 0.05, kRounding = 1e-9;

// Advances the Maxwell elements of one component, and returns the sum of their tractions, Pa. change: of the law's
// traction, Pa. Elements of lanes outside `holds` lose their traction.
template <class Load, class Store, class Mask>
HWY_INLINE V Relax(const MaxwellColumns& m, int component, V change, Mask holds, const Load& load, const Store& store) {
  const D d;
  V sum = hn::Zero(d);
  for (int e = 0; e < kMaxwellElements; ++e) {
    double* const column = m.traction[3 * e + component];
    const V grown = hn::MulAdd(hn::Set(d, m.keep[e]), load(column), hn::Mul(hn::Set(d, m.gain[e]), change));
    const V now = hn::IfThenElseZero(holds, grown);
    store(now, column);
    sum = hn::Add(sum, now);
  }
  return sum;
}

// kMaxwell needs kImpacts.
template <bool kImpacts, bool kMaxwell>
HWY_INLINE double Damp(const PointColumns& c, const MaxwellColumns& m, std::size_t count, const OfPoints& normal,
                       const OfPoints& along) {
  const D d;
  const V zero = hn::Zero(d), half = hn::Set(d, 0.5);
  LaneSum work;
  for_each_vector(D(), 0, count, [&](std::size_t i, auto load, auto store) HWY_ATTR {
    const V then = load(c.old_jump), now = load(c.normal_jump);
    const auto known = hn::Eq(then, then);  // NaN: a new point, without a rate
    const V way[3] = {hn::IfThenElseZero(known, hn::Sub(now, then)), load(c.slip[0]), load(c.slip[1])};
    V done = zero;
    const auto closed = hn::Lt(load(c.traction[0]), zero);
    V change[3];
    for (int k = 0; k < 3; ++k) change[k] = hn::Sub(load(c.traction[k]), load(c.old_traction[k]));
    const auto of_points = [&](const OfPoints& x) HWY_ATTR {
      const V all = hn::Set(d, x.all);
      return x.column ? hn::Mul(all, load(x.column)) : all;
    };
    // Whether the elements hold: the joint is in contact, and neither slides nor softens.
    const auto holds = [&](V power, V way2, V traction2, const OfPoints& stiffness) HWY_ATTR {
      const V k = of_points(stiffness), floor = hn::Set(d, kRounding * kRounding);
      const auto elastic = hn::Ge(power, hn::Mul(hn::Mul(hn::Set(d, kLettingGo), k), way2));
      const auto rests = hn::Le(hn::Mul(hn::Mul(k, k), way2), hn::Mul(floor, traction2));
      return hn::And(known, hn::And(hn::Or(elastic, rests), hn::Gt(traction2, zero)));
    };
    V elements[3] = {zero, zero, zero};
    // A joint whose shear falls while slip goes on slides under falling compression. Where the dashpot takes all of
    // that compression, shear may fall to zero, but not turn round.
    auto lets_go = hn::And(closed, hn::Lt(hn::MulAdd(change[1], way[1], hn::Mul(change[2], way[2])), zero));
    if (kMaxwell) {
      const V t0 = load(c.traction[0]), t1 = load(c.traction[1]), t2 = load(c.traction[2]);
      const V pressed2 = hn::Mul(t0, t0), sheared2 = hn::MulAdd(t1, t1, hn::Mul(t2, t2));
      const auto across = holds(hn::Mul(change[0], way[0]), hn::Mul(way[0], way[0]), pressed2, m.normal);
      const auto sideways = holds(hn::MulAdd(change[1], way[1], hn::Mul(change[2], way[2])),
                                  hn::MulAdd(way[1], way[1], hn::Mul(way[2], way[2])), sheared2, m.shear);
      for (int k = 0; k < 3; ++k)
        elements[k] = Relax(m, k, change[k], k == 0 ? across : hn::And(sideways, hn::Gt(pressed2, zero)), load, store);
    }
    for (int k = 0; k < 3; ++k) {
      const V traction = load(c.traction[k]);
      V viscous = hn::Mul(of_points(k == 0 ? normal : along), change[k]);
      if (kMaxwell) viscous = hn::Add(hn::IfThenElseZero(closed, viscous), elements[k]);
      const V whole = hn::Neg(traction);
      if (k == 0) {
        viscous = hn::IfThenElse(hn::Le(traction, zero), hn::Min(viscous, whole), viscous);
        lets_go = hn::And(lets_go, hn::Ge(viscous, whole));
      } else if (kImpacts) {
        viscous = hn::IfThenElse(lets_go, hn::Clamp(viscous, hn::Min(whole, zero), hn::Max(whole, zero)), viscous);
      }
      const auto touches = kImpacts && !kMaxwell ? closed : hn::Ne(traction, zero);
      viscous = hn::IfThenElseZero(hn::And(known, touches), viscous);
      // Central differences: half of the motion is under the traction of the last step.
      done = hn::MulAdd(hn::Add(load(c.viscous[k]), viscous), way[k], done);
      store(viscous, c.viscous[k]);
    }
    V& sum = work.part[part_of_sum(i)];
    sum = hn::MulAdd(hn::Mul(half, load(c.area)), done, sum);
    store(now, c.old_jump);
  });
  return work.total();
}

double DampPoints(const PointColumns& c, std::size_t count, double rate) {
  return Damp<false, false>(c, {}, count, {rate}, {rate});
}
double DampImpacts(const PointColumns& c, const MaxwellColumns& m, std::size_t count, const OfPoints& normal,
                   const OfPoints& along) {
  return m.traction[0] ? Damp<true, true>(c, m, count, normal, along) : Damp<true, false>(c, m, count, normal, along);
}

void SumEnergies(const double* area, BoundCall& call) {
  call.stored = 0.0, call.dissipated = {};
  if (!call.batch.energy_stored.data) return;
  LaneSum stored, dissipated[QUOIN_DISSIPATED_COUNT];
  for_each_vector(D(), 0, call.batch.count, [&](std::size_t i, auto load, auto) HWY_ATTR {
    const V of_points = load(area);
    const auto add = [&](const double* density, LaneSum& sum) HWY_ATTR {
      V& part = sum.part[part_of_sum(i)];
      part = hn::MulAdd(of_points, load(density), part);
    };
    add(call.batch.energy_stored.data, stored);
    for (int k = 0; k < QUOIN_DISSIPATED_COUNT; ++k) add(call.batch.dissipated[k].data, dissipated[k]);
  });
  call.stored = stored.total();
  for (std::size_t k = 0; k < call.dissipated.size(); ++k) call.dissipated[k] = dissipated[k].total();
}

}  // namespace HWY_NAMESPACE
}  // namespace quoin::blocks
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace quoin::blocks {

HWY_EXPORT(DampPoints);
HWY_EXPORT(DampImpacts);
HWY_EXPORT(SumEnergies);

PointColumns columns_of(Family& f, std::size_t first) {
  PointColumns c{};
  for (int k = 0; k < 3; ++k) {
    c.arm[k] = f.arm[k].data() + first, c.traction[k] = f.traction[k].data() + first;
    if (!f.viscous[0].empty()) c.viscous[k] = f.viscous[k].data() + first;
    if (!f.old_traction[0].empty()) c.old_traction[k] = f.old_traction[k].data() + first;
  }
  for (int k = 0; k < 2; ++k) c.slid[k] = f.slid[k].data() + first, c.slip[k] = f.slip[k].data() + first;
  c.offset = f.offset.data() + first, c.area = f.area.data() + first, c.normal_jump = f.normal_jump.data() + first;
  if (!f.old_jump.empty()) c.old_jump = f.old_jump.data() + first;
  return c;
}

double damp_points(const PointColumns& columns, std::size_t count, double rate) {
  return HWY_DYNAMIC_DISPATCH(DampPoints)(columns, count, rate);
}

double damp_impacts(const PointColumns& columns, const MaxwellColumns& maxwell, std::size_t count,
                    const OfPoints& normal, const OfPoints& along) {
  return HWY_DYNAMIC_DISPATCH(DampImpacts)(columns, maxwell, count, normal, along);
}

void sum_energies(const double* area, BoundCall& call) { HWY_DYNAMIC_DISPATCH(SumEnergies)(area, call); }

}  // namespace quoin::blocks

#endif  // HWY_ONCE
