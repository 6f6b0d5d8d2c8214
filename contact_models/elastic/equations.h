// The elastic joint: sigma = kn d_n, tau = tau_old + ks dd_s. fracture_energy/LAW.md, "The other laws that ship".
#if defined(QUOIN_ELASTIC_EQUATIONS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_ELASTIC_EQUATIONS_H
#undef QUOIN_ELASTIC_EQUATIONS_H
#else
#define QUOIN_ELASTIC_EQUATIONS_H
#endif

#include "elastic/parameters.h"
#include "shim/extras.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::elastic::HWY_NAMESPACE {
using namespace quoin::shim::HWY_NAMESPACE;
using shim::Columns;
using shim::Summary;

template <class Access>
HWY_INLINE void evaluate_columns(const Parameters& material, const Columns& c, std::size_t count, Summary& summary) {
  using namespace quoin::shim;
  const D d;
  const V half = splat(0.5);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto in = [&](int k) { return Access::load(c.in[k], i); };
    const auto property = [&](int k, double value) {
      return c.property_columns && c.in[kProperty + k] ? in(kProperty + k) : splat(value);
    };
    const V kn = property(0, material.kn), ks = property(1, material.ks);
    const V d_n = in(kNormalJump);
    const V sigma_old = in(kTractionOld);
    const V tau_s_old = in(kTractionOld + 1);
    const V tau_t_old = in(kTractionOld + 2);

    V sigma = hn::Mul(kn, d_n);
    V tau_s = hn::MulAdd(ks, in(kSlipIncrement), tau_s_old);
    V tau_t = hn::MulAdd(ks, in(kSlipIncrement + 1), tau_t_old);

    // Stiffnesses by column have the bounds of the property: positive and finite.
    V collected = gather_non_finite(sigma, gather_non_finite(tau_s, gather_non_finite(tau_t, zero())));
    const M sound = hn::And(is_finite(collected), hn::And(hn::Gt(kn, zero()), hn::Gt(ks, zero())));
    if (!all(sound)) {
      sigma = select(sound, sigma, sigma_old);
      tau_s = select(sound, tau_s, tau_s_old);
      tau_t = select(sound, tau_t, tau_t_old);
      summary.failed += hn::CountTrue(d, hn::AndNot(sound, hn::FirstN(d, count - i)));
    }
    Access::store(sigma, c.out[kTractionNew], i);
    Access::store(tau_s, c.out[kTractionNew + 1], i);
    Access::store(tau_t, c.out[kTractionNew + 2], i);

    if (!c.extras) continue;
    const V shear = hn::MulAdd(tau_s, tau_s, hn::Mul(tau_t, tau_t));
    const V stored = hn::Mul(half, hn::MulAdd(sigma, d_n, hn::Div(shear, ks)));
    const Energies energies{stored, zero(), zero(), zero(), zero()};
    const Tangent tangent{{kn, zero(), zero(), zero(), ks, zero(), zero(), zero(), ks}};
    put_extras(
        c, i, sound, energies, tangent, [&] { return flag_if(hn::Gt(d_n, zero()), QUOIN_FLAG_OPEN); },
        [](int) { return zero(); });
  }
}

inline void evaluate(const Parameters& material, const Columns& c, std::size_t count, Summary& summary) {
  evaluate_columns<Vectors>(material, c, count, summary);
}
inline void evaluate_one(const Parameters& material, const Columns& c, Summary& summary) {
  evaluate_columns<OnePoint>(material, c, 1, summary);
}

}  // namespace quoin::elastic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
