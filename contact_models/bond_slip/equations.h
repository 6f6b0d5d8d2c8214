// Bond of a strip to a face: LAW.md. Bilinear with fracture energy, unloading to the origin, mixed mode of slip and
// peel.
#if defined(QUOIN_BOND_SLIP_EQUATIONS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_BOND_SLIP_EQUATIONS_H
#undef QUOIN_BOND_SLIP_EQUATIONS_H
#else
#define QUOIN_BOND_SLIP_EQUATIONS_H
#endif

#include "bond_slip/parameters.h"
#include "shim/extras.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::bond_slip::HWY_NAMESPACE {
using namespace quoin::shim::HWY_NAMESPACE;

// over_s0 = 1/s0 = ks/tau_m, over_n0 = 1/n0 = kn/f_p; 0: the bond loses no strength. r: jump at the end of softening
// over the jump at its beginning.
struct Lanes {
  V kn, ks, over_s0, over_n0, r;
};

struct Jump {
  V d_n, s_s, s_t;  // at the end of the step, m
};

struct Result {
  V sigma, tau_s, tau_t;
  V lambda;
  V whole;  // undamaged share, 1 - D
  M grows;
};

struct Equations {
  const Lanes& p;

  HWY_INLINE V undamaged(V lambda) const {
    const V one = splat(1.0);
    const V softening = hn::Div(hn::Sub(p.r, lambda), hn::Mul(hn::Sub(p.r, one), hn::Max(lambda, one)));
    return select(hn::Gt(lambda, one), positive_part(softening), one);
  }

  // Returns the lost share of the strength.
  HWY_INLINE V lost(V lambda) const {
    const V one = splat(1.0);
    return hn::Min(one, positive_part(hn::Div(hn::Sub(lambda, one), hn::Sub(p.r, one))));
  }

  HWY_INLINE V relative(const Jump& j) const {
    const V opening = hn::Mul(positive_part(j.d_n), p.over_n0);
    const V slip = hn::Mul(hn::MulAdd(j.s_s, j.s_s, hn::Mul(j.s_t, j.s_t)), hn::Mul(p.over_s0, p.over_s0));
    return hn::Sqrt(hn::MulAdd(opening, opening, slip));
  }

  template <bool kFull>
  HWY_INLINE Result evaluate(const Jump& j, V lambda_old, Energies* energies, Tangent* tangent) const {
    const V one = splat(1.0), half = splat(0.5);
    const V trial = relative(j);
    Result r;
    // Damage of a debonded point does not grow.
    r.grows = hn::And(hn::Gt(trial, hn::Max(lambda_old, one)), hn::Lt(lambda_old, p.r));
    r.lambda = select(r.grows, hn::Min(trial, p.r), lambda_old);
    r.whole = undamaged(r.lambda);
    const M closed = hn::Le(j.d_n, zero());
    const V normal = hn::Mul(p.kn, select(closed, one, r.whole)), shear = hn::Mul(p.ks, r.whole);
    // + 0 avoids -0: min(0, -0) depends on the instruction set.
    r.sigma = hn::MulAdd(normal, j.d_n, zero());
    r.tau_s = hn::MulAdd(shear, j.s_s, zero());
    r.tau_t = hn::MulAdd(shear, j.s_t, zero());
    if constexpr (kFull) {
      const V slip2 = hn::MulAdd(j.s_s, j.s_s, hn::Mul(j.s_t, j.s_t));
      const V opening = positive_part(j.d_n);
      energies->stored = hn::Mul(half, hn::MulAdd(normal, hn::Mul(j.d_n, j.d_n), hn::Mul(shear, slip2)));
      // Dissipated: the growth of damage times the energy that an undamaged bond would store, e lambda^2/2 with e at
      // the end of the step.
      const V over = hn::IfThenElseZero(r.grows, hn::Div(one, hn::Max(trial, one)));
      const V e_n = hn::Mul(hn::Mul(p.kn, hn::Mul(opening, opening)), hn::Mul(over, over));
      const V e_s = hn::Mul(hn::Mul(p.ks, slip2), hn::Mul(over, over));
      const V way = positive_part(hn::Sub(r.lambda, hn::Max(lambda_old, one)));
      const V factor = hn::Mul(half, hn::Mul(way, hn::Div(p.r, hn::Sub(p.r, one))));
      energies->tension = hn::IfThenElseZero(r.grows, hn::Mul(factor, e_n));
      energies->cohesion = hn::IfThenElseZero(r.grows, hn::Mul(factor, e_s));
      energies->friction = energies->crushing = zero();

      // d(1 - D)/d(lambda) = -r/((r - 1) lambda^2) while damage grows.
      const M softens = hn::And(r.grows, hn::Lt(r.lambda, p.r));
      const V falls =
          hn::IfThenElseZero(softens, hn::Div(p.r, hn::Mul(hn::Sub(p.r, one), hn::Mul(r.lambda, r.lambda))));
      const V per = hn::Mul(falls, hn::Div(one, hn::Max(r.lambda, one)));
      const V by_n = hn::Mul(per, hn::Mul(opening, hn::Mul(p.over_n0, p.over_n0)));
      const V by_s = hn::Mul(per, hn::Mul(j.s_s, hn::Mul(p.over_s0, p.over_s0)));
      const V by_t = hn::Mul(per, hn::Mul(j.s_t, hn::Mul(p.over_s0, p.over_s0)));
      const V normal_force = hn::Mul(p.kn, opening), force_s = hn::Mul(p.ks, j.s_s), force_t = hn::Mul(p.ks, j.s_t);
      tangent->entry[0] = hn::NegMulAdd(normal_force, by_n, normal);
      tangent->entry[1] = hn::Neg(hn::Mul(normal_force, by_s));
      tangent->entry[2] = hn::Neg(hn::Mul(normal_force, by_t));
      tangent->entry[3] = hn::Neg(hn::Mul(force_s, by_n));
      tangent->entry[4] = hn::NegMulAdd(force_s, by_s, shear);
      tangent->entry[5] = hn::Neg(hn::Mul(force_s, by_t));
      tangent->entry[6] = hn::Neg(hn::Mul(force_t, by_n));
      tangent->entry[7] = hn::Neg(hn::Mul(force_t, by_s));
      tangent->entry[8] = hn::NegMulAdd(force_t, by_t, shear);
    }
    return r;
  }
};

}  // namespace quoin::bond_slip::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
