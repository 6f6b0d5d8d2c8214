// The loop over points around the equations, compiled for every instruction set.
#include "bond_slip/kernel.h"

#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bond_slip/kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "bond_slip/equations.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::bond_slip::HWY_NAMESPACE {
using namespace quoin::shim;

// Ratio r of a bond that loses no strength. Its value has no effect if it is above 1.
inline constexpr double kUnusedRatio = 2.0;

HWY_INLINE Lanes lanes_of(V kn, V ks, V tau_m, V f_p, V G_f) {
  const V over_s0 = hn::Div(ks, tau_m);
  const V ratio = hn::Mul(splat(2.0), hn::Div(hn::Mul(hn::Div(G_f, tau_m), ks), tau_m));
  return {kn, ks, over_s0, hn::Div(kn, f_p), select(hn::Gt(over_s0, zero()), ratio, splat(kUnusedRatio))};
}

template <bool kFull, class Access>
HWY_INLINE void run(const Parameters& m, const Columns& c, std::size_t count, Summary& summary) {
  const D d;
  const V one = splat(1.0);
  const Lanes uniform = lanes_of(splat(m.kn), splat(m.ks), splat(m.tau_m), splat(m.f_p), splat(m.G_f));
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto at = [&](int k) { return Access::load(c.in[k], i); };
    const auto put = [&](int k, V value) { Access::store(value, c.out[k], i); };
    Lanes p = uniform;
    M sound = hn::Eq(zero(), zero());
    if (kFull && c.property_columns) {
      const auto number = [&](int k, double value) {
        const double* column = c.in[kProperty + k];
        return column == nullptr ? splat(value) : load(column, i);
      };
      const V kn = number(kColumnKn, m.kn), ks = number(kColumnKs, m.ks), G_f = number(kColumnGf, m.G_f);
      const V tau_m = number(kColumnTauM, m.tau_m), f_p = number(kColumnFp, m.f_p);
      p = lanes_of(kn, ks, tau_m, f_p, G_f);
      // Each value by itself: NaN fails every comparison, but a minimum may drop it.
      const V positive[] = {kn, ks, tau_m, f_p, G_f}, finite[] = {kn, ks, p.r};
      for (const V value : positive) sound = hn::And(sound, hn::Gt(value, zero()));
      for (const V value : finite) sound = hn::And(sound, hn::Lt(value, splat(HUGE_VAL)));
      const M peel_alone = hn::And(hn::Eq(p.over_s0, zero()), hn::Gt(p.over_n0, zero()));
      sound = hn::AndNot(peel_alone, hn::And(sound, hn::Gt(p.r, one)));
    }
    const V old_s = at(kStateOld + kSlipS), old_t = at(kStateOld + kSlipT), old_lambda = at(kStateOld + kLambda);
    Jump jump{at(kNormalJump), hn::Add(old_s, at(kSlipIncrement)), hn::Add(old_t, at(kSlipIncrement + 1))};

    const Equations law{p};
    Energies energies;
    Tangent tangent;
    Result r = law.evaluate<kFull>(jump, old_lambda, &energies, &tangent);

    // One test for the whole vector: a value that is not finite, in or out, fails its point, whose outputs are the old
    // state.
    V collected = gather_non_finite(r.sigma, gather_non_finite(r.tau_s, gather_non_finite(r.tau_t, zero())));
    for (int k = 0; k < 3; ++k) collected = gather_non_finite(at(kTractionOld + k), collected);
    collected = gather_non_finite(r.lambda, gather_non_finite(old_lambda, gather_non_finite(jump.d_n, collected)));
    sound = hn::And(sound, is_finite(collected));
    if (!all(sound)) {
      r.sigma = select(sound, r.sigma, at(kTractionOld));
      r.tau_s = select(sound, r.tau_s, at(kTractionOld + 1));
      r.tau_t = select(sound, r.tau_t, at(kTractionOld + 2));
      r.lambda = select(sound, r.lambda, old_lambda);
      jump.s_s = select(sound, jump.s_s, old_s), jump.s_t = select(sound, jump.s_t, old_t);
      r.grows = hn::And(sound, r.grows);
      summary.failed += hn::CountTrue(d, hn::AndNot(sound, hn::FirstN(d, count - i)));
    }
    const V opening = at(kNormalJump);  // read before outputs are written, which may share memory with inputs
    put(kTractionNew, r.sigma);
    put(kTractionNew + 1, r.tau_s);
    put(kTractionNew + 2, r.tau_t);
    put(kStateNew + kSlipS, jump.s_s);
    put(kStateNew + kSlipT, jump.s_t);
    put(kStateNew + kLambda, r.lambda);
    summary.yielding |= !none(hn::And(r.grows, hn::FirstN(d, count - i)));

    if constexpr (kFull) {
      const V lost = law.lost(r.lambda);
      put_extras(
          c, i, sound, energies, tangent,
          [&] {
            V flags = flag_if(hn::Gt(opening, zero()), QUOIN_FLAG_OPEN);
            flags =
                hn::Add(flags, flag_if(hn::Gt(lost, zero()), QUOIN_FLAG_TENSION_DAMAGED | QUOIN_FLAG_SHEAR_DAMAGED));
            flags = hn::Add(flags, flag_if(hn::Ge(lost, one), QUOIN_FLAG_TENSION_COMPLETE | QUOIN_FLAG_SHEAR_COMPLETE));
            return hn::Add(flags, flag_if(r.grows, QUOIN_FLAG_YIELDING));
          },
          [&](int mode) { return mode == QUOIN_DAMAGE_CRUSHING ? zero() : lost; });
    }
  }
}

void evaluate(const Parameters& material, const Columns& c, std::size_t count, Summary& summary) {
  c.extras ? run<true, Vectors>(material, c, count, summary) : run<false, Vectors>(material, c, count, summary);
}
void evaluate_one(const Parameters& material, const Columns& c, Summary& summary) {
  run<false, OnePoint>(material, c, 1, summary);
}

}  // namespace quoin::bond_slip::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin::bond_slip {

HWY_EXPORT(evaluate);
HWY_EXPORT(evaluate_one);

void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate)(material, columns, count, summary);
}
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate_one)(material, columns, summary);
}

}  // namespace quoin::bond_slip
#endif
