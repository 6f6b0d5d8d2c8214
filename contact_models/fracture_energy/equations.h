// The fracture-energy contact law, in the order of LAW.md: softening, tension, closed joint, shear, energies, tangent.
// One vector lane is one contact point. Symbols as in LAW.md; SI units; sigma > 0 is tension, d_n > 0 opens.
#if defined(QUOIN_FRACTURE_ENERGY_EQUATIONS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_FRACTURE_ENERGY_EQUATIONS_H
#undef QUOIN_FRACTURE_ENERGY_EQUATIONS_H
#else
#define QUOIN_FRACTURE_ENERGY_EQUATIONS_H
#endif

#include <limits>

#include "fracture_energy/parameters.h"
#include "shim/extras.h"
#include "shim/root.h"
#include "shim/softening.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::fracture_energy::HWY_NAMESPACE {
using namespace quoin::shim::HWY_NAMESPACE;

// Parameters of each lane's point: the material's in every lane, or from property columns.
struct Lanes {
  V kn, ks, ft, c0, cr, mu0, mur, tan_psi, fc, fcr;
  V c_drop, mu_drop, fc_drop;  // c0 - cr, mu0 - mur, fc - fcr
  V strength;                  // the larger of ft and c0
  V inv_ks;
  V u0;               // elastic opening at ft
  V lt, inv_lt;       // kappa grows by lt per unit of xi
  V su, inv_su;       // slip per unit of xi_s
  V ks_in_softening;  // ks where cohesion decreases along the slip, 0 where it drops at once
  V wu, inv_wu;       // plastic closure per unit of F's argument
  // Value that xi jumps to at the first opening or slip: the end of softening for a mode without strength drop, else 0.
  V xi_at_first_opening, xi_at_first_slip;
  V end;                         // f(xi >= end) = 0
  V uplift_crushes;              // q/(1 - q), q: share of a dilation uplift that crushing takes up
  M crushing_sound, admissible;  // no snap-back (LAW.md, statement 6); admissible can be false only with columns

  Lanes() = default;
  HWY_INLINE Lanes(const Parameters& p, V kn_, V ks_, V ft_, V c0_, V cr_, V mu0_, V mur_, V tan_psi_, V fc_, V fcr_,
                   V G1, V G2, V Gc)
      : kn(kn_), ks(ks_), ft(ft_), c0(c0_), cr(cr_), mu0(mu0_), mur(mur_), tan_psi(tan_psi_), fc(fc_), fcr(fcr_) {
    end = splat(p.end);
    derive_crushing(p, Gc);
    derive(p, G1, G2);
  }

  // Sets the members that depend on kn, fc, fcr and Gc.
  HWY_INLINE void derive_crushing(const Parameters& p, V Gc) {
    const V m = splat(p.slope), one = splat(1.0);
    const M drops_c = hn::And(hn::Lt(fc, splat(HUGE_VAL)), hn::Gt(fc, fcr));
    fc_drop = hn::Sub(fc, fcr);
    wu = hn::IfThenElseZero(drops_c, hn::Div(Gc, hn::Mul(fc_drop, splat(p.A))));
    inv_wu = hn::IfThenElseZero(drops_c, hn::Div(one, wu));
    const V q = hn::IfThenElseZero(drops_c, hn::Div(hn::Mul(m, fc_drop), hn::Mul(wu, kn)));
    uplift_crushes = hn::Div(q, hn::Sub(one, q));
    crushing_sound = hn::Or(hn::Gt(hn::Mul(wu, kn), hn::Mul(m, fc_drop)), hn::Not(drops_c));
    crushing_sound = hn::And(crushing_sound, hn::And(hn::Le(fcr, fc), none_negative(fcr, Gc)));
  }

  // Sets all other derived members.
  HWY_INLINE void derive(const Parameters& p, V G1, V G2) {
    const V A = splat(p.A), m = splat(p.slope), one = splat(1.0), half = splat(0.5);
    const M drops_t = hn::Gt(ft, zero()), drops_s = hn::Gt(c0, cr);
    c_drop = hn::Sub(c0, cr), mu_drop = hn::Sub(mu0, mur);
    strength = hn::Max(ft, c0);
    inv_ks = hn::Div(one, ks);
    u0 = hn::Div(ft, kn);
    lt = hn::IfThenElseZero(drops_t, hn::Div(hn::NegMulAdd(hn::Mul(half, ft), u0, G1), hn::Mul(ft, A)));
    inv_lt = hn::IfThenElseZero(drops_t, hn::Div(one, lt));
    su = hn::IfThenElseZero(drops_s, hn::Div(G2, hn::Mul(c_drop, A)));
    inv_su = hn::IfThenElseZero(drops_s, hn::Div(one, su));
    ks_in_softening = hn::IfThenElseZero(drops_s, ks);
    xi_at_first_opening = hn::IfThenZeroElse(drops_t, end);
    xi_at_first_slip = hn::IfThenZeroElse(drops_s, end);
    const V P = hn::IfThenElseZero(hn::Lt(fc, splat(HUGE_VAL)), fc);
    const V steepest = hn::Mul(m, hn::Max(c0, hn::MulAdd(P, mu_drop, c_drop)));
    // Bound on the decrease of S along the slip by uplift, Pa/m: uplift crushes the joint, and S falls with the
    // pressure.
    const V by_uplift = hn::Mul(hn::Mul(kn, hn::Mul(mu0, tan_psi)), uplift_crushes);
    admissible = hn::And(crushing_sound, hn::And(hn::Gt(kn, zero()), hn::Gt(ks, zero())));
    admissible = hn::And(admissible, hn::Or(hn::Gt(lt, zero()), hn::Not(drops_t)));
    admissible = hn::And(admissible, hn::Or(hn::Gt(hn::Mul(su, hn::Sub(ks, by_uplift)), steepest), hn::Not(drops_s)));
    // Fracture energies are checked also for a mode without strength drop: a value that a material refuses fails a
    // point.
    admissible = hn::And(admissible, none_negative(mur, tan_psi, ft, cr, kn, ks, c0, G1, G2));
    admissible = hn::And(admissible, hn::And(hn::Le(mur, mu0), hn::Le(tan_psi, mu0)));
    admissible = hn::And(admissible, hn::Le(cr, c0));
  }

  // True where every value is finite and >= 0. For all properties but fc, which may be infinite.
  template <class... Values>
  static HWY_INLINE M none_negative(V first, Values... values) {
    V collected = gather_non_finite(first, zero()), least = first;
    ((collected = gather_non_finite(values, collected), least = hn::Min(least, values)), ...);
    return hn::And(is_finite(collected), hn::Ge(least, zero()));
  }
};

// History of the point (LAW.md, "State") and its traction, Pa.
struct State {
  V xi_t, xi_s, w, v;
  V tau_s, tau_t;
  V sigma;  // for the energies of a slip
};

struct Increment {
  V d_n;       // total, at the end of the step
  V d_s, d_t;  // sliding over the step
};

struct Result {
  State state;
  V sigma;
  V slip;   // over the step, >= 0, m
  V e;      // effective opening, m
  V trial;  // |tau*|; NaN where a slip meets an old sigma that is not finite, which its energies use
  M open, slips, crushes;
};

// Tolerance of the yield conditions, relative to the largest stress in the comparison: LAW.md, statement 5.
inline constexpr double kYieldTolerance = 8.0 * 2.220446049250313e-16;

template <class Softening, bool kShared, bool kCrushing, bool kDilation>
struct Equations {
  static constexpr bool kSharedDamage = kShared;
  const Lanes& p;
  const Softening f;

  // ---- Tension, e > 0 -------------------------------------------------------------------------------------------

  HWY_INLINE V kappa(V xi) const { return hn::MulAdd(xi, p.lt, p.u0); }

  // Secant stiffness ft f/kappa, written so that it is exactly kn at xi = 0; 0 where ft = 0.
  HWY_INLINE V secant(V xi) const { return secant(xi, f.factor(xi)); }
  HWY_INLINE V secant(V xi, V factor) const {
    const V ratio = hn::Div(hn::Mul(factor, p.u0), kappa(xi));
    return hn::IfThenElseZero(hn::Gt(p.ft, zero()), hn::Mul(p.kn, ratio));
  }
  HWY_INLINE V secant_slope(V xi) const {  // d secant / d xi
    const V k = kappa(xi);
    const V top = hn::Sub(hn::Mul(f.slope(xi), k), hn::Mul(f.factor(xi), p.lt));
    return hn::IfThenElseZero(hn::Gt(p.ft, zero()), hn::Div(hn::Mul(p.ft, top), hn::Mul(k, k)));
  }

  // ---- Closed, e <= 0 -------------------------------------------------------------------------------------------

  HWY_INLINE V crushing_strength(V w) const {  // F(w)
    return hn::MulAdd(p.fc_drop, f.factor(hn::Mul(w, p.inv_wu)), p.fcr);
  }
  HWY_INLINE V crushing_slope(V w) const {  // dF/dw <= 0
    return hn::Mul(hn::Mul(p.fc_drop, p.inv_wu), f.slope(hn::Mul(w, p.inv_wu)));
  }

  HWY_INLINE V overstress(V d_n_less_v, V w) const {
    return hn::Sub(hn::Neg(hn::Mul(p.kn, hn::Add(d_n_less_v, w))), crushing_strength(w));
  }
  // Returns the w at which the elastic stress is -F(w). Rare, so out of line with arguments by value: the common path
  // stays small.
  HWY_NOINLINE V crushing_closure(M crushes, V d_n_less_v, V w_old, V tolerance) const {
    // F >= fcr, so that w cannot pass the closure at which the elastic stress is fcr.
    const V highest = hn::Max(w_old, hn::Neg(hn::Add(d_n_less_v, hn::Div(p.fcr, p.kn))));
    V w;
    if constexpr (Softening::kShape == Shape::linear) {
      // F falls linearly up to wu and is fcr beyond it.
      const V fall = hn::Add(p.kn, crushing_slope(w_old));
      const V straight = hn::Add(w_old, hn::Div(overstress(d_n_less_v, w_old), fall));
      w = select(hn::Lt(highest, p.wu), hn::Min(straight, highest), highest);
    } else {
      w = find_root(crushes, w_old, w_old, highest, hn::Mul(splat(0.25), tolerance), [&](V x, V& value, V& slope) {
        value = overstress(d_n_less_v, x);
        slope = hn::Neg(hn::Add(p.kn, crushing_slope(x)));
      });
    }
    return select(crushes, hn::Max(w, w_old), w_old);
  }

  struct Closed {
    V sigma, w;
    M crushes;
    M crushed_out;  // F(w) = 0: the point carries no stress
  };
  // Solves sigma = kn (d_n + w - v) >= -F(w) for sigma and w; w grows from w_old only as far as the bound needs.
  HWY_INLINE Closed closed(M where, V d_n_less_v, V w_old, V tolerance) const {
    const M nowhere = hn::MaskFromVec(zero());
    Closed c{hn::Mul(p.kn, hn::Add(d_n_less_v, w_old)), w_old, nowhere, nowhere};
    if constexpr (kCrushing) {
      // 0 - F, not -F: max(0, -0) depends on the instruction set.
      V lowest = hn::Sub(zero(), crushing_strength(w_old));
      c.crushes = hn::And(where, hn::Gt(hn::Sub(lowest, c.sigma), tolerance));
      if (!none(c.crushes)) {
        // NaN where w_old is not finite: the closure that the pressure needs may be finite there.
        c.w = hn::MulAdd(w_old, zero(), crushing_closure(c.crushes, d_n_less_v, w_old, tolerance));
        c.sigma = hn::Mul(p.kn, hn::Add(d_n_less_v, c.w));
        lowest = hn::Sub(zero(), crushing_strength(c.w));
      }
      c.sigma = hn::Max(c.sigma, lowest);
      c.crushed_out = hn::Eq(lowest, zero());
    }
    return c;
  }
  HWY_INLINE V closed_slope(const Closed& c) const {  // d sigma / d d_n
    if constexpr (!kCrushing) return p.kn;
    const V soft = crushing_slope(c.w);
    return select(c.crushes, hn::Div(hn::Mul(p.kn, soft), hn::Add(p.kn, soft)), p.kn);
  }

  // ---- Shear ----------------------------------------------------------------------------------------------------

  // Values at the end of a given slip.
  struct AtSlip {
    V xi_s, factor, v, w, sigma, S;  // factor: f(xi_s)
    V S_end, S_drop;                 // c - sigma mu = S_end + S_drop f, at this sigma
    M crushes, crushed_out;
    // Derivatives of sigma and S by slip (at fixed d_n) and by d_n (at fixed slip), Pa/m.
    V sigma_slip, sigma_n, S_slip, S_n;
  };

  struct Step {
    V d_n, w_old, v_old;
    V e;              // with the old w and v
    V xi_t, xi_s;     // after the opening of this step
    V c_end, c_drop;  // c = c_end + c_drop f
    V tolerance;      // stress, Pa
    M open, opens;
    bool any_open;  // a lane of this vector is open
    Closed normal;  // with the old v
  };

  // Returns c - sigma mu. Linear in f, since c and mu = mur + (mu0 - mur) f are.
  HWY_INLINE V coulomb(const AtSlip& a, V factor) const { return hn::MulAdd(a.S_drop, factor, a.S_end); }

  // Solves for xi_s, dilation uplift v, crushing w, sigma and the strength S at the end of a given slip.
  template <bool kSlopes>
  HWY_INLINE AtSlip at_slip(const Step& step, V slip) const {
    return at_xi<kSlopes>(step, hn::MulAdd(slip, p.inv_su, step.xi_s));
  }
  template <bool kSlopes>
  HWY_INLINE AtSlip at_xi(const Step& step, V xi_s) const {
    AtSlip a;
    a.xi_s = xi_s;
    const V factor = f.factor(a.xi_s);
    a.factor = factor;
    a.v = step.v_old;
    Closed c = step.normal;
    if constexpr (kDilation) {
      const V uplift = hn::Mul(hn::Mul(p.tan_psi, p.su), f.area(step.xi_s, a.xi_s));
      a.v = select(step.open, step.v_old, hn::Add(step.v_old, uplift));
      c = closed(hn::Not(step.open), hn::Sub(step.d_n, a.v), step.w_old, step.tolerance);
    }
    const V xi = kShared ? a.xi_s : step.xi_t;
    a.w = c.w;
    a.crushes = c.crushes;
    a.crushed_out = c.crushed_out;
    a.sigma = c.sigma;
    V K = zero(), K_xi = zero();
    if (step.any_open) {
      // Skips the secant where all open joints are fully softened: the most common case in a cracked wall.
      if (!none(hn::And(step.open, hn::Lt(xi, p.end)))) {
        K = secant(xi, kShared ? factor : f.factor(xi));
        if constexpr (kSlopes) K_xi = hn::Mul(secant_slope(xi), step.e);
      }
      a.sigma = select(step.open, hn::Mul(K, step.e), c.sigma);
    }
    a.S_end = hn::NegMulAdd(a.sigma, p.mur, step.c_end);
    a.S_drop = hn::NegMulAdd(a.sigma, p.mu_drop, step.c_drop);
    if constexpr (kCrushing) {
      // S is 0 on both sides of e = 0, where rounding of w may put the point.
      a.S_end = hn::IfThenZeroElse(a.crushed_out, a.S_end);
      a.S_drop = hn::IfThenZeroElse(a.crushed_out, a.S_drop);
    }
    const V S = coulomb(a, factor);  // tension reduces S: Coulomb's line extends to its apex
    a.S = positive_part(S);

    if constexpr (kSlopes) {
      const V mu = hn::MulAdd(p.mu_drop, factor, p.mur);
      V stiffness = closed_slope(c);
      if constexpr (kCrushing) stiffness = hn::IfThenZeroElse(a.crushed_out, stiffness);  // sigma stays 0
      const V xi_t_by_n = hn::IfThenElseZero(step.opens, p.inv_lt);
      a.sigma_slip = zero();
      if constexpr (kDilation) a.sigma_slip = hn::Neg(hn::Mul(stiffness, hn::Mul(p.tan_psi, factor)));
      const V sigma_slip_open = kShared ? hn::Mul(K_xi, p.inv_su) : zero();
      a.sigma_slip = select(step.open, sigma_slip_open, a.sigma_slip);
      a.sigma_n = select(step.open, hn::MulAdd(K_xi, xi_t_by_n, K), stiffness);
      const V S_xi = hn::Mul(a.S_drop, f.slope(a.xi_s));
      a.S_slip = hn::NegMulAdd(mu, a.sigma_slip, hn::Mul(S_xi, p.inv_su));
      a.S_n = hn::Neg(hn::Mul(mu, a.sigma_n));
      if constexpr (kShared) a.S_n = hn::MulAdd(hn::IfThenElseZero(step.open, S_xi), xi_t_by_n, a.S_n);
      const M held = hn::Gt(S, zero());
      a.S_slip = hn::IfThenElseZero(held, a.S_slip);
      a.S_n = hn::IfThenElseZero(held, a.S_n);
    }
    return a;
  }

  HWY_INLINE static bool sigma_follows_slip(const Step& step) { return kDilation || (kShared && step.any_open); }

  // Returns at_xi at xi_s, given start, the solution without slip. Where sigma does not depend on slip, only f changes.
  template <bool kSlopes>
  HWY_INLINE AtSlip after_slip(const Step& step, const AtSlip& start, V xi_s) const {
    if (kSlopes || sigma_follows_slip(step)) return at_xi<kSlopes>(step, xi_s);
    AtSlip a = start;
    a.xi_s = xi_s;
    a.factor = f.factor(xi_s);
    a.S = positive_part(coulomb(a, a.factor));
    return a;
  }

  // Computes the slip at which |tau*| - ks slip = S(slip). Beyond the end of softening S is constant. With linear
  // softening and constant sigma it falls linearly before. In all other cases the slip is the root of a falling
  // function. start: solution without slip. xi_start: xi_s where the slip starts; for a cohesion without drop the end
  // of softening. Returns true if end has been set to the solution at the slip.
  HWY_INLINE bool slip_to_strength(M slips, const Step& step, V trial, const AtSlip& start, V xi_start, V& slip,
                                   AtSlip& end) const {
    const V beyond = hn::Mul(positive_part(hn::Sub(trial, strength_beyond(step, start))), p.inv_ks);
    slip = beyond;
    M curved = slips;
    if constexpr (Softening::kShape == Shape::linear) {
      // The line and the constant after it form a convex function, so the smaller of both slips is the answer.
      slip = hn::Min(straight_slip(trial, start), beyond);
      if (!sigma_follows_slip(step)) {
        slip = hn::IfThenElseZero(slips, slip);
        return false;
      }
      curved = hn::MaskFromVec(zero());
      if constexpr (kShared) curved = hn::And(step.open, slips);
      if constexpr (kDilation) curved = hn::Or(curved, hn::And(slips, hn::Gt(p.tan_psi, zero())));
    }
    slip = hn::IfThenElseZero(slips, select(curved, beyond, slip));
    const V slip_at_end = hn::Mul(p.su, positive_part(hn::Sub(p.end, step.xi_s)));
    const M within = hn::AndNot(hn::Ge(beyond, slip_at_end), curved);
    if (none(within)) return false;
    if constexpr (Softening::kShape == Shape::exponential) {
      slip = root_slip(within, slip, short_slip(trial, start), slip_at_end, step, trial, xi_start, end);
      return true;
    }
    const Step copy = step;  // curved_slip takes the address of the copy, so that step stays in registers
    slip = curved_slip(within, slip, slip_at_end, copy, trial, xi_start);
    return false;
  }
  // Returns the slip to the line S' = S_drop f', f' = -1/su. S_drop < 0, where S would rise with slip, has S < 0.
  // Infinite where S falls faster than ks, and for a cohesion that drops at once.
  HWY_INLINE V straight_slip(V trial, const AtSlip& start) const {
    const V approach = hn::NegMulAdd(positive_part(start.S_drop), p.inv_su, p.ks_in_softening);
    return hn::Mul(hn::Sub(trial, start.S), hn::Div(splat(1.0), positive_part(approach)));
  }
  // Out of line, so that the common path stays small.
  HWY_NOINLINE V curved_slip(M curved, V slip, V slip_at_end, const Step& step, V trial, V xi_start) const {
    V guess = zero();
    if constexpr (Softening::kShape == Shape::linear && kShared) {
      guess = hn::IfThenElseZero(step.open, opening_slip(step, trial, xi_start));
    }
    AtSlip end;
    return root_slip(curved, slip, guess, slip_at_end, step, trial, xi_start, end);
  }
  HWY_INLINE V root_slip(M curved, V slip, V guess, V slip_at_end, const Step& step, V trial, V xi_start,
                         AtSlip& end) const {
    const V highest = hn::Min(slip_at_end, hn::Div(trial, p.ks));
    const V first = hn::Min(positive_part(guess), highest);
    return find_root(
        curved, select(curved, first, slip), zero(), highest,
        hn::Mul(splat(0.25), step.tolerance), [&](V x, V & value, V & slope) __attribute__((always_inline)) {
          end = at_xi<true>(step, hn::MulAdd(x, p.inv_su, xi_start));
          value = hn::Sub(hn::NegMulAdd(p.ks, x, trial), end.S);
          slope = hn::Neg(hn::Add(p.ks, end.S_slip));
        });
  }
  // Slip under exponential softening and constant sigma: with x = slip/su, D = S_drop f and c the excess of |tau*|,
  // ks su x - D (1 - exp(-x)) = c, c the excess of |tau*|. Series in q = c/b, b = ks su - D > 0, up to the fourth
  // power. It is exact to rounding for the short steps of an explicit analysis, and a first guess for longer ones.
  HWY_INLINE V short_slip(V trial, const AtSlip& start) const {
    const V D = hn::Mul(start.S_drop, start.factor);
    const V inv_b = hn::Div(splat(1.0), hn::MulSub(p.ks, p.su, D));
    const V q = hn::Mul(hn::Sub(hn::Sub(trial, start.S_end), D), inv_b), r = hn::Mul(D, inv_b);
    const V third = hn::MulAdd(splat(1.0 / 2.0), r, splat(1.0 / 6.0));
    const V fourth = hn::MulAdd(hn::MulAdd(splat(5.0 / 8.0), r, splat(5.0 / 12.0)), r, splat(1.0 / 24.0));
    const V bend = hn::MulAdd(hn::NegMulAdd(fourth, q, third), q, splat(-1.0 / 2.0));
    return hn::Mul(hn::MulAdd(hn::Mul(r, bend), hn::Mul(q, q), q), p.su);
  }
  // Slip of an open joint with linear softening, with the friction coefficient at xi_start. With xi = xi_start + x and
  // kappa = kappa_0 + lt x, kappa (|tau*| - ks su x) = kappa S = (f - x) (c0 kappa - mu ft e). This is a quadratic
  // equation a x^2 + b x + c = 0 with one positive root, which is the slip but for rounding and for S = 0.
  HWY_INLINE V opening_slip(const Step& step, V trial, V xi_start) const {
    const V f_0 = f.factor(xi_start), kappa_0 = kappa(xi_start);
    const V mu = hn::MulAdd(p.mu_drop, f_0, p.mur);
    const V held = hn::NegMulAdd(hn::Mul(mu, p.ft), step.e, hn::Mul(p.c0, kappa_0));
    const V ks_su = hn::Mul(p.ks, p.su);
    const V a = hn::Mul(p.lt, hn::Sub(p.c0, ks_su));  // < 0: no snap-back
    const V b = hn::MulAdd(p.lt, hn::NegMulAdd(p.c0, f_0, trial), hn::NegMulAdd(ks_su, kappa_0, held));
    const V c = hn::NegMulAdd(f_0, held, hn::Mul(trial, kappa_0));
    const V root = hn::Sqrt(hn::NegMulAdd(hn::Mul(splat(4.0), a), c, hn::Mul(b, b)));
    const V larger = hn::Add(hn::Abs(b), root);  // no cancellation
    const M rising = hn::Gt(b, zero());
    const V x = hn::Div(select(rising, larger, hn::Add(c, c)), select(rising, hn::Neg(hn::Add(a, a)), larger));
    return hn::Mul(x, p.su);
  }
  // Returns S at the end of softening, f = 0.
  HWY_INLINE V strength_beyond(const Step& step, const AtSlip& start) const {
    if constexpr (kDilation) return at_xi<false>(step, hn::Max(step.xi_s, p.end)).S;
    // With shared softening sigma of an open joint is 0 there, too.
    return positive_part(kShared ? hn::IfThenZeroElse(step.open, start.S_end) : start.S_end);
  }

  // ---- Nothing yields: the short path ---------------------------------------------------------------------------

  // If every lane is elastic at full stiffness, writes the result, bitwise identical to evaluate, and returns true. A
  // lane is elastic if |tau*| < S and its joint is closed with sigma > -F, or never opened beyond u0. kOpeningFirst:
  // tests the opening before all else.
  template <bool kOpeningFirst>
  HWY_INLINE bool elastic(const Increment& in, const State& old, Result& r) const {
    const V e = hn::Add(hn::Sub(in.d_n, old.v), old.w);
    const V sigma = hn::Mul(p.kn, e);
    // The limit is NaN if xi is not finite; f(xi) may be finite then.
    V limit_e = hn::MulAdd(old.xi_s, zero(), hn::IfThenElseZero(hn::Eq(old.xi_t, zero()), p.u0));
    if constexpr (!kShared) limit_e = hn::MulAdd(old.xi_t, zero(), limit_e);
    const M full_stiffness = hn::Le(e, limit_e);
    if (kOpeningFirst && !all(full_stiffness)) return false;
    const V trial_s = hn::MulAdd(p.ks, in.d_s, old.tau_s);
    const V trial_t = hn::MulAdd(p.ks, in.d_t, old.tau_t);
    const V factor = f.factor(old.xi_s);
    const V mu = hn::MulAdd(p.mu_drop, factor, p.mur);
    // Without the residual cohesion, which an open joint lacks: a lower bound of S for open and closed joints.
    const V S = hn::NegMulAdd(sigma, mu, hn::Mul(p.c_drop, factor));
    const V trial_squared = hn::MulAdd(trial_s, trial_s, hn::Mul(trial_t, trial_t));
    // Less, not equal: squares that overflow, and values that are not finite, take the whole step.
    const M held = hn::Lt(trial_squared, hn::Mul(S, hn::Abs(S)));
    M uncrushed = hn::Ge(sigma, splat(std::numeric_limits<double>::lowest()));
    // Greater, not equal: a point that is crushed out has no strength at any sigma.
    if constexpr (kCrushing) uncrushed = hn::Gt(crushing_strength(old.w), hn::Max(hn::Neg(sigma), zero()));
    if (!all(hn::And(held, hn::And(full_stiffness, uncrushed)))) return false;
    r.sigma = sigma;
    r.state = old;
    r.state.tau_s = trial_s;
    r.state.tau_t = trial_t;
    return true;
  }

  // ---- The step: w from d_n and the old v; xi by opening; then v, slip, xi, sigma and w together; tau last -------

  template <bool kEnergies, bool kTangent>
  HWY_INLINE Result evaluate(const Increment& in, const State& old, Energies* energies, Tangent* tangent) const {
    Step step;
    step.d_n = in.d_n;
    step.w_old = old.w;
    step.v_old = old.v;
    step.e = hn::Add(hn::Sub(in.d_n, old.v), old.w);
    step.open = hn::Gt(step.e, zero());
    step.any_open = !none(step.open);
    step.opens = hn::MaskFromVec(zero());
    step.xi_t = old.xi_t;
    step.c_end = p.cr;
    step.c_drop = p.c_drop;
    const V reach = hn::Add(hn::Abs(in.d_n), hn::Add(old.w, old.v));
    if (step.any_open) {
      // Opening: xi = (e - u0)/lt beyond kappa(xi).
      const V tolerance_e = hn::Mul(splat(kYieldTolerance), hn::Max(p.u0, reach));
      step.opens = hn::And(step.open, hn::Gt(hn::Sub(step.e, kappa(old.xi_t)), tolerance_e));
      const V xi_opened = hn::Max(hn::Mul(hn::Sub(step.e, p.u0), p.inv_lt), p.xi_at_first_opening);
      step.xi_t = select(step.opens, hn::Max(old.xi_t, xi_opened), old.xi_t);
      // The residual cohesion acts only while the joint is closed.
      step.c_end = hn::IfThenZeroElse(step.open, p.cr);
      step.c_drop = select(step.open, p.c0, p.c_drop);
    }
    step.xi_s = kShared ? step.xi_t : old.xi_s;

    const V trial_s = hn::MulAdd(p.ks, in.d_s, old.tau_s);
    const V trial_t = hn::MulAdd(p.ks, in.d_t, old.tau_t);
    const V trial = hn::Sqrt(hn::MulAdd(trial_s, trial_s, hn::Mul(trial_t, trial_t)));
    const V scale = hn::Max(hn::Max(p.strength, hn::Mul(p.kn, reach)), trial);
    step.tolerance = hn::Mul(splat(kYieldTolerance), scale);
    step.normal = closed(hn::Not(step.open), hn::Sub(in.d_n, old.v), old.w, step.tolerance);

    // Elastic trial against the strength before any slip; when the joint opens or closes, tau returns to the new S.
    AtSlip a = at_xi<kTangent>(step, step.xi_s);
    Result r;
    r.slips = hn::Gt(hn::Sub(trial, a.S), step.tolerance);
    const V S_before_slip = a.S;
    r.slip = zero();
    r.trial = trial;
    r.state.tau_s = trial_s;
    r.state.tau_t = trial_t;
    V tau = trial;
    V xi_start =
        step.xi_s;  // xi_s where the slip of this step starts: the end of softening for a cohesion without drop
    if (!none(r.slips)) {
      xi_start = hn::Max(step.xi_s, hn::IfThenElseZero(r.slips, p.xi_at_first_slip));
      AtSlip end;
      if (slip_to_strength(r.slips, step, trial, a, xi_start, r.slip, end)) {
        a = end;
      } else {
        a = after_slip<kTangent>(step, a, hn::MulAdd(r.slip, p.inv_su, xi_start));
      }
      tau = select(r.slips, a.S, trial);
      r.trial = hn::MulAdd(hn::IfThenElseZero(r.slips, old.sigma), zero(), trial);
      // The direction first, so that the division does not wait for the strength.
      const V inv_trial = hn::Div(splat(1.0), trial);
      r.state.tau_s = select(r.slips, hn::Mul(hn::Mul(trial_s, inv_trial), a.S), trial_s);
      r.state.tau_t = select(r.slips, hn::Mul(hn::Mul(trial_t, inv_trial), a.S), trial_t);
    }

    r.open = step.open;
    r.crushes = a.crushes;
    r.sigma = a.sigma;
    r.e = hn::Add(hn::Sub(in.d_n, a.v), a.w);
    r.state.w = a.w;
    r.state.v = a.v;
    r.state.xi_s = a.xi_s;
    r.state.xi_t = kShared ? a.xi_s : step.xi_t;

    if constexpr (kEnergies) *energies = energies_of(old, step, xi_start, a, r, trial, S_before_slip, tau);
    if constexpr (kTangent) *tangent = tangent_of(a, r, trial_s, trial_t, trial, tau);
    return r;
  }

  // ---- Energies, from internal variables only -------------------------------------------------------------------

  HWY_NOINLINE Energies energies_of(const State& old, const Step& step, const V& xi_start, const AtSlip& a,
                                    const Result& r, const V& trial, const V& S_before_slip, const V& tau) const {
    const V half = splat(0.5);
    Energies E;
    const V normal = hn::Mul(half, select(r.open, hn::Mul(r.sigma, r.e), hn::Mul(p.kn, hn::Mul(r.e, r.e))));
    E.stored = hn::Add(normal, hn::Div(hn::Mul(half, hn::Mul(tau, tau)), p.ks));

    // Opening: area under the envelope less the change of the stored energy, which is f kappa ft/2 on the envelope:
    //   ft/2 (2 lt area - f1 kappa1 + f0 kappa0), f0 kappa0 - f1 kappa1 = kappa0 (f0 - f1) - f1 lt (xi1 - xi0)
    const V passed = hn::Mul(splat(2.0), hn::Mul(p.lt, f.area(old.xi_t, step.xi_t)));
    const V freed = hn::Sub(hn::Mul(kappa(old.xi_t), f.drop(old.xi_t, step.xi_t)),
                            hn::Mul(hn::Mul(f.factor(step.xi_t), p.lt), hn::Sub(step.xi_t, old.xi_t)));
    E.tension = hn::IfThenElseZero(step.opens, hn::Mul(hn::Mul(half, p.ft), hn::Add(passed, freed)));
    if constexpr (kShared) {  // slip lowers the secant stiffness at constant opening
      const V lost = hn::Sub(secant(step.xi_t), secant(a.xi_s));
      const V by_slip = hn::Mul(hn::Mul(half, lost), hn::Mul(step.e, step.e));
      E.tension = hn::Add(E.tension, hn::IfThenElseZero(hn::And(r.open, r.slips), by_slip));
    }
    E.tension = positive_part(E.tension);

    // Slip. Exact integrals over the slip of mu and of the closed joint's cohesion.
    const V softened = hn::Mul(p.su, f.area(step.xi_s, a.xi_s));  // integral of f over the slip
    const V friction_path = hn::MulAdd(p.mu_drop, softened, hn::Mul(p.mur, r.slip));
    // The pressure is taken as linear over the step: the error under impact and unloading is of second order.
    const V pressure = hn::Mul(half, hn::Add(positive_part(hn::Neg(old.sigma)), positive_part(hn::Neg(r.sigma))));
    E.friction = positive_part(hn::Mul(pressure, hn::Sub(friction_path, hn::Sub(a.v, step.v_old))));
    const V cohesion_closed = hn::MulAdd(p.c_drop, softened, hn::Mul(p.cr, r.slip));
    V cohesion_open;
    if constexpr (kShared) {
      // S(slip) = c0 f - sigma(xi) mu by Simpson's rule up to the end of softening; S is 0 beyond.
      const V up_to = hn::Min(r.slip, hn::Mul(p.su, positive_part(hn::Sub(p.end, step.xi_s))));
      const V middle = at_slip<false>(step, hn::Mul(half, up_to)).S;
      const V last = at_slip<false>(step, up_to).S;
      const V sum = hn::Add(hn::MulAdd(splat(4.0), middle, S_before_slip), last);
      cohesion_open = hn::Mul(hn::Div(up_to, splat(6.0)), sum);
    } else {
      cohesion_open = hn::NegMulAdd(r.sigma, friction_path, hn::Mul(p.c0, softened));
    }
    // lost: cohesion that drops at once, in three cases. A joint that opens loses its residual. A mode without strength
    // drop completes at its first movement. A point is crushed out. The drop releases what the old tau stored above the
    // new strength. A change of pressure is no such drop: it is gradual in a step of any length.
    V start = S_before_slip;
    V lost = hn::IfThenElseZero(
        r.open, hn::Sub(hn::MulAdd(p.c_drop, f.factor(old.xi_s), p.cr), hn::Mul(p.c0, f.factor(step.xi_s))));
    const M dropped = hn::Gt(xi_start, step.xi_s);
    if (!none(dropped)) {
      start = select(dropped, at_xi<false>(step, xi_start).S, start);
      lost = select(dropped, hn::Sub(S_before_slip, start), lost);
    }
    const V held = hn::Sqrt(hn::MulAdd(old.tau_s, old.tau_s, hn::Mul(old.tau_t, old.tau_t)));
    const V before = hn::Min(trial, hn::Max(held, S_before_slip));
    if constexpr (kCrushing) {
      start = hn::IfThenZeroElse(a.crushed_out, start);
      lost = select(a.crushed_out, before, lost);
    }
    const V excess = positive_part(hn::Min(hn::Sub(before, start), lost));
    // tau decreases along the elastic line until it meets S, which falls with the slip.
    const V fall = hn::IfThenElseZero(hn::Gt(r.slip, zero()), hn::Div(hn::Sub(tau, start), r.slip));
    const V freed_at_once = hn::Div(hn::Mul(half, hn::Mul(excess, excess)), hn::Add(p.ks, hn::Min(fall, zero())));
    V along_slip = positive_part(select(r.open, cohesion_open, cohesion_closed));
    if constexpr (kCrushing) along_slip = hn::IfThenZeroElse(a.crushed_out, along_slip);
    E.cohesion = hn::Add(along_slip, freed_at_once);
    // Where |tau*| does not exceed the old |tau|, the whole slip is on that line.
    const M standing = hn::And(hn::And(r.open, hn::Gt(excess, zero())), hn::Le(trial, held));
    E.cohesion = select(standing, hn::Mul(hn::Mul(half, hn::Add(trial, tau)), r.slip), E.cohesion);
    E.cohesion = hn::IfThenElseZero(r.slips, E.cohesion);
    E.friction = hn::IfThenElseZero(r.slips, E.friction);

    E.crushing = zero();
    if constexpr (kCrushing) {
      const V work = hn::Mul(hn::Mul(p.fc_drop, p.wu), f.area(hn::Mul(step.w_old, p.inv_wu), hn::Mul(a.w, p.inv_wu)));
      const V total = hn::MulAdd(p.fcr, hn::Sub(a.w, step.w_old), work);  // without drop F = fc = fcr
      E.crushing = hn::IfThenElseZero(r.crushes, positive_part(total));
    }
    return E;
  }

  // ---- Consistent tangent: implicit derivative of the end-of-step equations --------------------------------------

  HWY_INLINE Tangent tangent_of(const AtSlip& a, const Result& r, V trial_s, V trial_t, V trial, V tau) const {
    const V one = splat(1.0);
    const V inv_trial = hn::IfThenElseZero(hn::Gt(trial, zero()), hn::Div(one, trial));
    const V n_s = hn::Mul(trial_s, inv_trial), n_t = hn::Mul(trial_t, inv_trial);
    // A joint without strength that is open or crushed out slips by the least movement.
    M idle = r.open;
    if constexpr (kCrushing) idle = hn::Or(idle, a.crushed_out);
    const M slips = hn::Or(r.slips, hn::And(idle, hn::Eq(hn::Max(a.S, trial), zero())));
    // |tau*| - ks slip - S(slip, d_n) = 0
    const V inv_slope = hn::Div(one, hn::Add(p.ks, a.S_slip));
    const V slip_by_trial = hn::IfThenElseZero(slips, inv_slope);
    const V slip_by_n = hn::IfThenElseZero(slips, hn::Neg(hn::Mul(a.S_n, inv_slope)));
    const V along = hn::NegMulAdd(p.ks, slip_by_trial, one);       // d|tau| / d|tau*|
    const V across = select(slips, hn::Mul(tau, inv_trial), one);  // |tau| / |tau*|
    const V tau_by_n = hn::Neg(hn::Mul(p.ks, slip_by_n));
    const V sigma_by_trial = hn::Mul(hn::Mul(a.sigma_slip, slip_by_trial), p.ks);
    const V spread = hn::Sub(along, across);
    Tangent t;
    t.entry[0] = hn::MulAdd(a.sigma_slip, slip_by_n, a.sigma_n);
    t.entry[1] = hn::Mul(sigma_by_trial, n_s);
    t.entry[2] = hn::Mul(sigma_by_trial, n_t);
    t.entry[3] = hn::Mul(tau_by_n, n_s);
    t.entry[4] = hn::Mul(p.ks, hn::MulAdd(spread, hn::Mul(n_s, n_s), across));
    t.entry[5] = hn::Mul(p.ks, hn::Mul(spread, hn::Mul(n_s, n_t)));
    t.entry[6] = hn::Mul(tau_by_n, n_t);
    t.entry[7] = t.entry[5];
    t.entry[8] = hn::Mul(p.ks, hn::MulAdd(spread, hn::Mul(n_t, n_t), across));
    return t;
  }
};

}  // namespace quoin::fracture_energy::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
