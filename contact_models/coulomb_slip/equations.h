// The standard brittle joint law that the paper compares with (Figure 8): fracture_energy/LAW.md, "The other laws that
// ship". At the first failure in tension or in shear all strengths drop to their residuals; compression is elastic.
#if defined(QUOIN_COULOMB_SLIP_EQUATIONS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_COULOMB_SLIP_EQUATIONS_H
#undef QUOIN_COULOMB_SLIP_EQUATIONS_H
#else
#define QUOIN_COULOMB_SLIP_EQUATIONS_H
#endif

#include "coulomb_slip/parameters.h"
#include "shim/extras.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::coulomb_slip::HWY_NAMESPACE {
using namespace quoin::shim::HWY_NAMESPACE;

struct Lanes {
  V kn, ks, ft, ftr, c0, cr, mu0, mur;
  V inv_kn, inv_ks;  // for energies, m/Pa
};

struct Increment {
  V d_n;       // total, at the end of the step
  V d_s, d_t;  // sliding over the step
};

struct State {
  M failed;
  V tau_s, tau_t;
  V sigma;  // for the energies of a slip
};

struct Result {
  State state;
  V sigma, slip;
  M open, fails, slips;
};

// Tolerance of the yield conditions, relative to the largest stress in the comparison: fracture_energy/LAW.md,
// statement 5.
inline constexpr double kYieldTolerance = 8.0 * 2.220446049250313e-16;

struct Equations {
  const Lanes& p;

  HWY_INLINE V strength(V sigma, M open, M failed) const {
    const V mu = select(failed, p.mur, p.mu0);
    const V residual = hn::IfThenZeroElse(open, p.cr);
    return positive_part(hn::NegMulAdd(sigma, mu, select(failed, residual, p.c0)));
  }

  // Returns the recoverable energy of the normal spring with its cut-off at the tensile strength. The cut-off is
  // reversible: the joint closes at d_n = 0.
  HWY_INLINE V normal_energy(V d_n, V cut_off) const {
    const V elastic = hn::Min(d_n, hn::Mul(cut_off, p.inv_kn));
    const V beyond = hn::Sub(d_n, elastic);
    return hn::MulAdd(cut_off, beyond, hn::Mul(splat(0.5), hn::Mul(p.kn, hn::Mul(elastic, elastic))));
  }

  template <bool kFull>
  HWY_INLINE Result evaluate(const Increment& in, const State& old, Energies* energies, Tangent* tangent) const {
    const V half = splat(0.5);
    const V trial_s = hn::MulAdd(p.ks, in.d_s, old.tau_s);
    const V trial_t = hn::MulAdd(p.ks, in.d_t, old.tau_t);
    const V trial = hn::Sqrt(hn::MulAdd(trial_s, trial_s, hn::Mul(trial_t, trial_t)));
    // + 0 avoids -0: min(0, -0) depends on the instruction set.
    const V elastic = hn::MulAdd(p.kn, in.d_n, zero());
    const V scale = hn::Max(hn::Max(hn::Max(p.ft, p.c0), hn::Abs(elastic)), trial);
    const V tolerance = hn::Mul(splat(kYieldTolerance), scale);

    // Tension cut-off. Failure in tension drops all strengths before the shear strength is checked.
    Result r;
    r.open = hn::Gt(in.d_n, zero());
    const M breaks = hn::AndNot(old.failed, hn::Gt(hn::Sub(elastic, p.ft), tolerance));
    M failed = hn::Or(old.failed, breaks);
    V cut_off = select(failed, p.ftr, p.ft);
    r.sigma = hn::Min(elastic, cut_off);

    const V S_before_slip = strength(r.sigma, r.open, failed);
    r.slips = hn::Gt(hn::Sub(trial, S_before_slip), tolerance);
    const M shears = hn::AndNot(failed, r.slips);
    V S = S_before_slip;
    V tau = trial;
    r.state.tau_s = trial_s;
    r.state.tau_t = trial_t;
    r.slip = zero();
    if (!none(r.slips)) {
      failed = hn::Or(failed, r.slips);
      cut_off = select(failed, p.ftr, p.ft);
      r.sigma = hn::Min(elastic, cut_off);
      S = strength(r.sigma, r.open, failed);
      tau = select(r.slips, S, trial);
      r.slip = hn::IfThenElseZero(r.slips, hn::Div(hn::Sub(trial, S), p.ks));
      // NaN where the old sigma is not finite: the energy of friction takes it.
      const V keep = hn::MulAdd(old.sigma, zero(), hn::Div(tau, trial));
      r.state.tau_s = select(r.slips, hn::Mul(trial_s, keep), trial_s);
      r.state.tau_t = select(r.slips, hn::Mul(trial_t, keep), trial_t);
    }
    r.state.failed = failed;
    r.fails = hn::Or(breaks, shears);

    if constexpr (kFull) {
      energies->stored = hn::Add(normal_energy(in.d_n, cut_off), hn::Mul(hn::Mul(half, hn::Mul(tau, tau)), p.inv_ks));
      // The drop of the cut-off releases the energy stored above it. It is evaluated at ft for failure in tension, and
      // at the current opening for failure in shear.
      const V opening_at_drop = select(breaks, hn::Mul(p.ft, p.inv_kn), in.d_n);
      const V freed = hn::Sub(normal_energy(opening_at_drop, p.ft), normal_energy(opening_at_drop, p.ftr));
      energies->crushing = zero();
      energies->tension = hn::IfThenElseZero(r.fails, positive_part(freed));
      // Friction takes the mean pressure of the step. Cohesion takes S and the pressure at its end.
      const V pressure = positive_part(hn::Neg(r.sigma));
      const V mean_pressure = hn::Mul(half, hn::Add(positive_part(hn::Neg(old.sigma)), pressure));
      const V slip_friction = hn::Mul(p.mur, r.slip);
      energies->friction = hn::IfThenElseZero(r.slips, hn::Mul(mean_pressure, slip_friction));
      // Work of slip at S, and the energy of the excess over S that a drop of the strengths releases.
      const V held = hn::Sqrt(hn::MulAdd(old.tau_s, old.tau_s, hn::Mul(old.tau_t, old.tau_t)));
      const V excess = hn::Sub(hn::Min(trial, hn::Max(held, S_before_slip)), S);
      const V whole = hn::NegMulAdd(r.sigma, select(old.failed, p.mur, p.mu0), select(old.failed, p.cr, p.c0));
      const V lost = positive_part(hn::Min(excess, hn::Sub(whole, S)));
      const V cohesive = hn::NegMulAdd(pressure, slip_friction, hn::Mul(S, r.slip));
      const V freed_at_once = hn::Mul(hn::Mul(half, hn::Mul(lost, lost)), p.inv_ks);
      energies->cohesion = hn::IfThenElseZero(r.slips, hn::Add(positive_part(cohesive), freed_at_once));

      const M plateau = hn::Gt(elastic, cut_off);
      const V sigma_n = hn::IfThenZeroElse(plateau, p.kn);
      const V inv_trial = hn::IfThenElseZero(hn::Gt(trial, zero()), hn::Div(splat(1.0), trial));
      const V n_s = hn::Mul(trial_s, inv_trial), n_t = hn::Mul(trial_t, inv_trial);
      // An open joint without strength slips by the least movement.
      const M slips = hn::Or(r.slips, hn::And(r.open, hn::Eq(hn::Max(S, trial), zero())));
      const V across = select(slips, hn::Mul(tau, inv_trial), splat(1.0));
      const V along = hn::IfThenZeroElse(slips, splat(1.0));
      const M rubs = hn::And(r.slips, hn::Gt(S, zero()));
      const V tau_n = hn::IfThenElseZero(rubs, hn::Neg(hn::Mul(p.mur, sigma_n)));
      const V spread = hn::Sub(along, across);
      tangent->entry[0] = sigma_n;
      tangent->entry[1] = tangent->entry[2] = zero();
      tangent->entry[3] = hn::Mul(tau_n, n_s);
      tangent->entry[4] = hn::Mul(p.ks, hn::MulAdd(spread, hn::Mul(n_s, n_s), across));
      tangent->entry[5] = hn::Mul(p.ks, hn::Mul(spread, hn::Mul(n_s, n_t)));
      tangent->entry[6] = hn::Mul(tau_n, n_t);
      tangent->entry[7] = tangent->entry[5];
      tangent->entry[8] = hn::Mul(p.ks, hn::MulAdd(spread, hn::Mul(n_t, n_t), across));
    }
    return r;
  }
};

}  // namespace quoin::coulomb_slip::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
