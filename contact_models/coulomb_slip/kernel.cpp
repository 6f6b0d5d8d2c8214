// The loop over points around the equations, compiled for every instruction set.
#include "coulomb_slip/kernel.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "coulomb_slip/kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "coulomb_slip/equations.h"
#include "shim/friction_column.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::coulomb_slip::HWY_NAMESPACE {
using namespace quoin::shim;

HWY_INLINE Lanes material_lanes(const Parameters& m) {
  return {splat(m.kn), splat(m.ks),  splat(m.ft),  splat(m.ftr),      splat(m.c0),
          splat(m.cr), splat(m.mu0), splat(m.mur), splat(1.0 / m.kn), splat(1.0 / m.ks)};
}
inline Lanes column_lanes(const Parameters& m, const Columns& c, std::size_t i) {
  const auto number = [&](int k, double value) {
    const double* column = c.in[kProperty + k];
    return column == nullptr ? splat(value) : load(column, i);
  };
  const V mu0 = friction_column(c.in[kProperty + kColumnPhi0], i, splat(m.mu0));
  const V mur = friction_column(c.in[kProperty + kColumnPhir], i, residual_friction(m.mur, m.own_mur, mu0));
  const V kn = number(kColumnKn, m.kn), ks = number(kColumnKs, m.ks);
  return {
      kn,  ks,  number(kColumnFt, m.ft), number(kColumnFtr, m.ftr), number(kColumnC0, m.c0), number(kColumnCr, m.cr),
      mu0, mur, hn::Div(splat(1.0), kn), hn::Div(splat(1.0), ks)};
}

HWY_INLINE M admissible(const Lanes& p) {
  const M stiff = hn::And(hn::Gt(p.kn, zero()), hn::Gt(p.ks, zero()));
  const V smallest = hn::Min(p.ftr, hn::Min(p.cr, p.mur));
  const V largest = hn::Max(hn::Max(p.kn, p.ks), hn::Max(p.ft, p.c0));
  const M finite = hn::Lt(largest, splat(HUGE_VAL));
  const M ordered = hn::And(hn::Le(p.ftr, p.ft), hn::And(hn::Le(p.cr, p.c0), hn::Le(p.mur, p.mu0)));
  return hn::And(hn::And(stiff, finite), hn::And(ordered, hn::Ge(smallest, zero())));
}

template <bool kFull, class Access>
HWY_INLINE void run(const Parameters& material, const Columns& c, std::size_t count, Summary& summary) {
  const D d;
  const Lanes uniform = material_lanes(material);
  const V one = splat(1.0);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto at = [&](int k) { return Access::load(c.in[k], i); };
    const auto put = [&](int k, V value) { Access::store(value, c.out[k], i); };
    const Lanes p = kFull && c.property_columns ? column_lanes(material, c, i) : uniform;
    const Equations law{p};
    const Increment in{at(kNormalJump), at(kSlipIncrement), at(kSlipIncrement + 1)};
    const V failed_old = at(kStateOld + kFailed);
    const State old{hn::Gt(failed_old, zero()), at(kTractionOld + 1), at(kTractionOld + 2), at(kTractionOld)};

    Energies energies;
    Tangent tangent;
    Result r = law.evaluate<kFull>(in, old, &energies, &tangent);

    // One test for the whole vector: a value that is not finite, in or out, fails its point, whose outputs are the old
    // state.
    V collected = gather_non_finite(r.sigma, gather_non_finite(r.state.tau_s, zero()));
    collected = gather_non_finite(r.state.tau_t, gather_non_finite(in.d_n, gather_non_finite(failed_old, collected)));
    M sound = is_finite(collected);
    if (kFull && c.property_columns) sound = hn::And(sound, admissible(p));
    V failed = hn::IfThenElseZero(r.state.failed, one);
    if (!all(sound)) {
      r.sigma = select(sound, r.sigma, at(kTractionOld));
      r.state.tau_s = select(sound, r.state.tau_s, old.tau_s);
      r.state.tau_t = select(sound, r.state.tau_t, old.tau_t);
      failed = select(sound, failed, failed_old);
      r.slip = hn::IfThenElseZero(sound, r.slip);
      r.slips = hn::And(sound, r.slips);
      r.fails = hn::And(sound, r.fails);
      summary.failed += hn::CountTrue(d, hn::AndNot(sound, hn::FirstN(d, count - i)));
    }

    put(kTractionNew, r.sigma);
    put(kTractionNew + 1, r.state.tau_s);
    put(kTractionNew + 2, r.state.tau_t);
    put(kStateNew + kFailed, failed);
    if (c.out[kStateNew + kSlip]) {
      put(kStateNew + kSlip, hn::Add(at(kStateOld + kSlip), r.slip));
    }
    const M moved = hn::Or(r.fails, r.slips);
    summary.yielding |= !none(hn::And(moved, hn::FirstN(d, count - i)));

    if constexpr (kFull) {
      put_extras(
          c, i, sound, energies, tangent,
          [&] {
            const M damaged = hn::Gt(failed, zero());
            V flags = flag_if(r.open, QUOIN_FLAG_OPEN);
            flags = hn::Add(flags, flag_if(r.slips, QUOIN_FLAG_SLIPPING));
            flags = hn::Add(flags, flag_if(damaged, QUOIN_FLAG_TENSION_DAMAGED | QUOIN_FLAG_TENSION_COMPLETE |
                                                        QUOIN_FLAG_SHEAR_DAMAGED | QUOIN_FLAG_SHEAR_COMPLETE));
            return hn::Add(flags, flag_if(moved, QUOIN_FLAG_YIELDING));
          },
          [&](int mode) { return mode == QUOIN_DAMAGE_CRUSHING ? zero() : failed; });
    }
  }
}

void evaluate(const Parameters& material, const Columns& c, std::size_t count, Summary& summary) {
  c.extras ? run<true, Vectors>(material, c, count, summary) : run<false, Vectors>(material, c, count, summary);
}
void evaluate_one(const Parameters& material, const Columns& c, Summary& summary) {
  run<false, OnePoint>(material, c, 1, summary);
}

}  // namespace quoin::coulomb_slip::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin::coulomb_slip {

HWY_EXPORT(evaluate);
HWY_EXPORT(evaluate_one);

void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate)(material, columns, count, summary);
}
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate_one)(material, columns, summary);
}

}  // namespace quoin::coulomb_slip
#endif
