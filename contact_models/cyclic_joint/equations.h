// The cyclic joint law, in the order of LAW.md: parameters, opening, slip of an open and of a closed joint, cap,
// update, energies, tangent. One vector lane is one contact point. Symbols as in LAW.md; SI units; sigma > 0 is
// tension, d_n > 0 opens.
#if defined(QUOIN_CYCLIC_JOINT_EQUATIONS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_CYCLIC_JOINT_EQUATIONS_H
#undef QUOIN_CYCLIC_JOINT_EQUATIONS_H
#else
#define QUOIN_CYCLIC_JOINT_EQUATIONS_H
#endif

#include <type_traits>

#include "cyclic_joint/parameters.h"
#include "shim/extras.h"
#include "shim/known_mask.h"
#include "shim/root.h"
#include "shim/softening.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::cyclic_joint::HWY_NAMESPACE {
using namespace quoin::shim::HWY_NAMESPACE;

// ---- Parameters of each lane's point: the material's in every lane, or from property columns -----------------------

struct Given {
  V kn, ks, ft, c0, cr, mu0, mur, tan_psi, fc, fcr, G1, G2, Gc, beta, sd, pd, fy, wp, chi, Cs;
};

struct Lanes {
  V kn, ks, ft, c0, cr, mu0, mur, tan_psi, fc, fcr, beta, fy, wp, Cs;
  V c_drop, mu_drop, fc_drop;  // c0 - cr, mu0 - mur, fc - fcr
  V strength;                  // the larger of ft and c0
  V inv_kn, inv_ks, inv_fc;    // inv_fc: 0 without crushing
  V u0, lt, inv_lt, su, inv_su, wu, inv_wu, sd, inv_sd, inv_pd, inv_wp;
  V hardening;                              // fc - fy
  V compliance_by_crushing;                 // chi/fc
  V half_chi;                               // chi/(2 fc)
  V yield, yield_squared;                   // F(0)
  V xi_at_first_opening, xi_at_first_slip;  // end of softening for a mode without strength drop, else 0
  V inv_c0_su;                              // 1/(c0 su)
  V end;                                    // f(xi >= end) = 0
  M admissible;                             // LAW.md, "Refused"; can be false only with columns
  bool hardens;                             // a lane hardens before the peak
  bool recovers;                            // a lane has chi > 0
  bool stays_open;                          // a lane has beta > 0

  Lanes() = default;
  HWY_INLINE Lanes(const Parameters& p, const Given& g)
      : kn(g.kn),
        ks(g.ks),
        ft(g.ft),
        c0(g.c0),
        cr(g.cr),
        mu0(g.mu0),
        mur(g.mur),
        tan_psi(g.tan_psi),
        fc(g.fc),
        fcr(g.fcr),
        beta(g.beta),
        fy(g.fy),
        Cs(g.Cs) {
    const V A = splat(p.A), m = splat(p.slope), one = splat(1.0), half = splat(0.5);
    const M drops_t = ft > zero(), drops_s = c0 > cr;
    const M crushes = fc < splat(HUGE_VAL), drops_c = hn::And(crushes, fc > fcr);
    end = splat(p.end);
    c_drop = c0 - cr, mu_drop = mu0 - mur, fc_drop = fc - fcr;
    strength = hn::Max(ft, c0);
    inv_kn = one / kn, inv_ks = one / ks, inv_fc = hn::IfThenElseZero(crushes, one / fc);
    u0 = ft / kn;
    lt = hn::IfThenElseZero(drops_t, (g.G1 - half * ft * u0) / (ft * A));
    inv_lt = hn::IfThenElseZero(drops_t, one / lt);
    su = hn::IfThenElseZero(drops_s, g.G2 / (c_drop * A));
    inv_su = hn::IfThenElseZero(drops_s, one / su);
    inv_c0_su = hn::IfThenElseZero(drops_s, one / (c0 * su));
    wu = hn::IfThenElseZero(drops_c, g.Gc / (fc_drop * A));
    inv_wu = hn::IfThenElseZero(drops_c, one / wu);
    sd = select(g.sd > zero(), g.sd, su);
    inv_sd = hn::IfThenElseZero(sd > zero(), one / sd);
    inv_pd = one / g.pd;
    wp = hn::IfThenElseZero(crushes, g.wp);
    hardens = !none(wp > zero());
    inv_wp = hn::IfThenElseZero(wp > zero(), one / wp);
    recovers = !none(g.chi > zero());
    stays_open = !none(beta > zero());
    hardening = hn::IfThenElseZero(crushes, fc - fy);
    yield = select(wp > zero(), fy, fc);
    yield_squared = yield * yield;
    compliance_by_crushing = g.chi * inv_fc, half_chi = half * compliance_by_crushing;
    xi_at_first_opening = hn::IfThenZeroElse(drops_t, end);
    xi_at_first_slip = hn::IfThenZeroElse(drops_s, end);

    const V P = hn::IfThenElseZero(crushes, fc);
    const V steepest = hn::IfThenElseZero(drops_s, m * hn::Max(c0, c_drop + P * mu_drop) * inv_su);
    const V moment = splat(p.moment) * compliance_by_crushing;
    const V fall =
        hn::IfThenElseZero(drops_c, fc_drop * (m * (inv_kn + compliance_by_crushing * wp) * inv_wu + moment));
    admissible = hn::And(kn > zero(), ks > zero());
    const auto require = [&](M holds) { admissible = hn::And(admissible, holds); };
    require(hn::Or(lt > zero(), hn::Not(drops_t)));  // 1
    require(ks > steepest + mu0 * kn * tan_psi);     // 2
    require(fall < one);                             // 3
    require(hn::Or(hn::Or(wu > zero(), hn::Not(drops_c)), hn::Not(crushes)));
    require(hn::Or(ks * Cs >= (one + g.chi) * kn, hn::Not(crushes)));               // 4
    require(tan_psi <= mur);                                                        // 5
    require(hn::And(hn::And(mur <= mu0, cr <= c0), hn::And(fcr <= fc, fy <= fc)));  // 6
    require(hn::Or(sd > zero(), tan_psi == zero()));
    require(hn::Or(hn::Or(fy == fc, g.wp > zero()), hn::Not(crushes)));
    require(hn::And(beta <= one, g.chi < one));
    // One by one: a minimum may drop a NaN.
    for (const V value : {mur, tan_psi, fcr, g.G1, g.G2, g.Gc, ft, cr, beta, g.sd, g.wp, g.chi})
      require(value >= zero());
    for (const V value : {g.pd, fc, fy, Cs}) require(value > zero());
    for (const V value : {kn, ks, ft, c0, fcr, g.G1, g.G2, g.Gc, g.sd, g.wp, Cs}) require(value < splat(HUGE_VAL));
  }
};

// The members of Lanes that the short path reads for joints without residual opening, crushing and uplift.
struct ShortLanes {
  V kn, ks, c_drop, mu_drop, mur, Cs, u0, yield, yield_squared;
  explicit HWY_INLINE ShortLanes(const Lanes& p)
      : kn(p.kn),
        ks(p.ks),
        c_drop(p.c_drop),
        mu_drop(p.mu_drop),
        mur(p.mur),
        Cs(p.Cs),
        u0(p.u0),
        yield(p.yield),
        yield_squared(p.yield_squared) {}
};

// ---- State ----------------------------------------------------------------------------------------------------------

struct State {
  V xi, kappa, q, l, w, g_s, g_t, r_m, v_m;
  V tau_s, tau_t;
};

HWY_INLINE State either(M mask, const State& yes, const State& no) {
  const auto one = [&](V a, V b) { return hn::IfThenElse(mask, a, b); };
  return {one(yes.xi, no.xi),   one(yes.kappa, no.kappa), one(yes.q, no.q),        one(yes.l, no.l),
          one(yes.w, no.w),     one(yes.g_s, no.g_s),     one(yes.g_t, no.g_t),    one(yes.r_m, no.r_m),
          one(yes.v_m, no.v_m), one(yes.tau_s, no.tau_s), one(yes.tau_t, no.tau_t)};
}

struct Increment {
  V d_n;       // total, at the end of the step
  V d_s, d_t;  // sliding over the step
};

struct Result {
  State state;
  V sigma;
  V gamma;  // slip over the step, >= 0
  V h;      // opening beyond the residual one
  V trial;  // |tau*|
  V used;   // 0, or NaN where a state that the step used is not finite
  M opens, slips, reseats, crushes, gives_way;
};

struct Traction {
  V sigma, tau_s, tau_t;
};

// Tolerance of the yield conditions, relative to the largest stress in the comparison.
inline constexpr double kYieldTolerance = 8.0 * 2.220446049250313e-16;

template <class Softening, class Numbers = const Lanes&>
struct Equations {
  const Numbers p;
  const Softening f;

  // ---- Crushing: strength F(l), compliance C(l), bond b(l) ----------------------------------------------------------

  HWY_INLINE V beyond_peak(V l) const { return positive_part(l - p.wp) * p.inv_wu; }

  HWY_INLINE V F(V l) const {
    const V softened = hn::MulAdd(p.fc_drop, f.factor(beyond_peak(l)), p.fcr);
    if (!p.hardens) return softened;
    const V x = l * p.inv_wp;
    return select(l < p.wp, hn::MulAdd(p.hardening, x * (splat(2.0) - x), p.fy), softened);
  }
  HWY_INLINE V F_slope(V l) const {
    const V softens = p.fc_drop * p.inv_wu * f.slope(beyond_peak(l));
    if (!p.hardens) return softens;
    const V rises = splat(2.0) * p.hardening * p.inv_wp * (splat(1.0) - l * p.inv_wp);
    return select(l < p.wp, rises, softens);
  }
  HWY_INLINE V F_area(V l0, V l1) const {  // integral of F from l0 to l1
    const V softening = p.fc_drop * p.wu * f.area(beyond_peak(l0), beyond_peak(l1));
    const V softened = hn::MulAdd(p.fcr, positive_part(l1 - p.wp) - positive_part(l0 - p.wp), softening);
    if (!p.hardens) return softened;
    const V a = hn::Min(l0, p.wp) * p.inv_wp, b = hn::Min(l1, p.wp) * p.inv_wp;
    const V mean = a + b - splat(1.0 / 3.0) * (a * a + a * b + b * b);  // mean of x (2 - x)
    return hn::MulAdd(p.wp * (b - a), hn::MulAdd(p.hardening, mean, p.fy), softened);
  }
  HWY_INLINE V recovery(V l0, V l1) const {  // chi/(2 fc) times the integral of F from l0 to l1
    return p.recovers ? p.half_chi * F_area(l0, l1) : zero();
  }
  HWY_INLINE V C(V l) const { return hn::MulAdd(p.compliance_by_crushing, l, p.inv_kn); }

  struct Crushed {
    V E, F, b;  // stiffness 1/C, strength, share of the bond left by crushing
  };
  HWY_INLINE Crushed crushed(V l) const {
    Crushed c{p.kn, p.yield, splat(1.0)};
    if (!none(l > zero())) {
      const Crushed softer = crushed_before(l);
      c.E = softer.E, c.F = softer.F, c.b = softer.b;  // by member, so that all three stay in registers
    }
    return c;
  }
  HWY_NOINLINE Crushed crushed_before(V l) const {
    const V strength = select(l > zero(), F(l), p.yield);  // the same bits beside crushed and uncrushed points
    const V softer = hn::MulAdd(p.kn * p.compliance_by_crushing, l, splat(1.0));
    return {p.kn / softer, strength, bond(l, strength)};
  }
  HWY_INLINE V bond(V l, V strength) const {
    const M softens = hn::And(l > p.wp, p.fc_drop > zero());  // fc (1/fc) may not be 1
    return select(softens, strength * p.inv_fc, splat(1.0));
  }

  // ---- Seat of the faces: v from g ----------------------------------------------------------------------------------

  // v is not finite if v_m is not, or if v_m is not 0 and g or r_m is not finite.
  HWY_INLINE V uplift(const State& s) const {
    const M none_left = s.v_m == zero();
    if (all(none_left)) return zero();
    const V r = hn::Sqrt(hn::MulAdd(s.g_s, s.g_s, s.g_t * s.g_t));
    return hn::IfThenZeroElse(none_left, hn::MulAdd(r + s.r_m, zero(), on_ramp(s, r)));
  }
  HWY_INLINE V on_ramp(const State& s, V r) const {
    return s.v_m * hn::IfThenZeroElse(s.r_m == zero(), hn::Min(splat(1.0), r / s.r_m));
  }

  // ---- Quantities of a step that open and closed joints share: LAW.md, ORDER, 0 -------------------------------------

  struct Step {
    const State& old;
    V d_n;
    V v, e, h;  // at the old states, m
    V trial_s, trial_t, t, n_s, n_t;
    V reach;          // |d_n| + w + v + q
    V floor;          // stress scale of every test, Pa: the larger of kn reach and |tau*|
    Crushed crushed;  // at the old l
    explicit HWY_INLINE Step(const State& state) : old(state) {}
    HWY_INLINE V tolerance(V strength) const { return splat(kYieldTolerance) * hn::Max(strength, floor); }
  };
  template <bool kUncrushed>  // true: l = 0 in every lane
  HWY_INLINE Step step_of(const Increment& in, const State& old) const {
    Step s(old);
    s.d_n = in.d_n;
    s.v = uplift(old);
    s.e = in.d_n - s.v + old.w;
    s.h = s.e - old.q;
    s.trial_s = hn::MulAdd(p.ks, in.d_s, old.tau_s);
    s.trial_t = hn::MulAdd(p.ks, in.d_t, old.tau_t);
    s.t = hn::Sqrt(hn::MulAdd(s.trial_s, s.trial_s, s.trial_t * s.trial_t));
    const V inv_t = hn::IfThenZeroElse(s.t == zero(), splat(1.0) / s.t);
    s.n_s = s.trial_s * inv_t, s.n_t = s.trial_t * inv_t;
    s.reach = hn::Abs(in.d_n) + (old.w + s.v + old.q);
    s.floor = hn::Max(p.kn * s.reach, s.t);
    s.crushed = kUncrushed ? Crushed{p.kn, p.yield, splat(1.0)} : crushed(old.l);
    return s;
  }

  // ---- Nothing yields: the short path -------------------------------------------------------------------------------

  static HWY_INLINE M untouched(const State& s) { return hn::Or(hn::Or(s.q, s.l), s.v_m) == zero(); }  // bitwise or

  // If every lane is elastic at full stiffness, writes the traction, bitwise identical to evaluate, and returns true.
  // Normal condition: the joint is closed and does not reduce a residual opening, or it never opened beyond u0. Shear
  // condition: |tau*| is within the strength. kOpeningFirst: tests the opening before all else. kUntouched: true only
  // where q, l and v_m are 0, and the seat's other states are not read.
  template <bool kOpeningFirst, bool kUntouched>
  HWY_INLINE bool elastic(const Increment& in, const State& old, Traction& traction) const {
    V h, virgin = hn::IfThenElseZero(old.xi == zero(), p.u0);
    Crushed c{p.kn, p.yield, splat(1.0)};
    if constexpr (kUntouched) {
      h = in.d_n + old.w;
    } else {
      h = in.d_n - uplift(old) + old.w - old.q;
      virgin = hn::MulAdd(old.l, zero(), hn::IfThenElseZero(old.l == zero(), virgin));
      c = crushed(old.l);
    }
    // The limit is NaN if xi is not finite; f(xi) may be finite then.
    const M full_stiffness = h <= hn::MulAdd(old.xi, zero(), virgin);
    if (kOpeningFirst && !all(full_stiffness)) return false;
    const V sigma = hn::MulAdd(c.E, h, zero());  // + 0 avoids -0
    const V trial_s = hn::MulAdd(p.ks, in.d_s, old.tau_s);
    const V trial_t = hn::MulAdd(p.ks, in.d_t, old.tau_t);
    const V factor = f.factor(old.xi);
    const V mu = hn::MulAdd(p.mu_drop, factor, p.mur);
    // Without the residual cohesion, which an open joint lacks: a lower bound of S for open and closed joints.
    const V S = hn::NegMulAdd(sigma, mu, kUntouched ? p.c_drop * factor : p.c_drop * c.b * factor);
    const V trial_squared = hn::MulAdd(trial_s, trial_s, trial_t * trial_t);
    // Less, not equal: squares that overflow, and values that are not finite, take the whole step.
    const M held = trial_squared < S * hn::Abs(S);
    // The cap is tested also in tension: this is on the safe side, and a sigma that is not finite fails the test.
    const V F_squared = kUntouched ? p.yield_squared : c.F * c.F;
    const M within_cap = hn::MulAdd(sigma, sigma, p.Cs * trial_squared) < F_squared;
    M elastic = hn::And(hn::And(held, full_stiffness), within_cap);
    if constexpr (kUntouched) {
      elastic = hn::And(elastic, untouched(old));
    } else {
      elastic = hn::And(elastic, hn::Or(old.q == zero(), zero() - sigma < p.ft));
    }
    if (!all(elastic)) return false;
    traction = {sigma, trial_s, trial_t};
    return true;
  }

  // ---- Open, 1: opening ---------------------------------------------------------------------------------------------

  // Returns the largest opening so far, at least u0. So the initial state does not depend on ft, which may be a column.
  HWY_INLINE V reached(const State& s) const { return select(s.xi == zero(), p.u0, hn::Max(s.kappa, p.u0)); }

  struct Opening {
    V xi, kappa, q, h;
    V passed;  // integral of f over the growth of xi
    V s0, T;   // stress on the bonded share, and c0 - mu0 s0 >= 0, Pa
    M opens;
  };
  template <bool kEnergies, class Open>
  HWY_INLINE Opening opening(const Step& s, Open open) const {
    const State& old = s.old;
    Opening o{old.xi, reached(old), old.q, s.h, zero(), zero(), zero(), hn::MaskFromVec(zero())};
    const V further = s.e - o.kappa;
    o.opens = both(open, p.kn * further > s.tolerance(p.ft));
    if (!none(o.opens)) {
      const V xi = hn::Max(hn::MulAdd(further, p.inv_lt, old.xi), p.xi_at_first_opening);
      o.xi = select(o.opens, xi, old.xi);
      if (kEnergies || p.stays_open) o.passed = f.area(old.xi, o.xi);
      o.q = hn::MulAdd(p.beta * p.lt, o.passed, old.q);
      o.kappa = select(o.opens, s.e, o.kappa);
      o.h = s.e - o.q;
    }
    // kn u0 in place of ft, so that s0 is exactly kn h while xi = 0.
    o.s0 = hn::IfThenElseZero(p.ft > zero(), p.kn * (p.u0 / (o.kappa - o.q)) * o.h);
    o.T = positive_part(hn::NegMulAdd(p.mu0, o.s0, p.c0));
    return o;
  }

  // ---- Slip to a strength that depends on f alone: open, 2; closed, 3, where the seat does not move ----------------

  // Root of t - ks gamma = S_end + S_drop f(xi + rate gamma).
  struct Line {
    V xi, rate, S_end, S_drop;
    HWY_INLINE V at(V factor) const { return hn::MulAdd(S_drop, factor, S_end); }
  };
  HWY_INLINE V slip_to(M slips, const Line& line, V factor, V t, V tolerance) const {
    const V beyond = positive_part(t - line.S_end) * p.inv_ks;  // f = 0 at the end of the slip
    if constexpr (Softening::kShape == Shape::linear) {
      // The line and the constant after it form a convex function, so the smaller of both slips is the answer.
      const V approach = hn::NegMulAdd(line.S_drop, line.rate, p.ks);
      const V straight = (t - line.at(factor)) / positive_part(approach);
      return hn::IfThenElseZero(slips, select(factor > zero(), hn::Min(straight, beyond), beyond));
    }
    const M within = hn::And(slips, hn::MulAdd(beyond, line.rate, line.xi) < p.end);
    if (none(within)) return hn::IfThenElseZero(slips, beyond);
    return hn::IfThenElseZero(slips, curved_slip(within, line, factor, t, beyond, tolerance));
  }
  HWY_INLINE V curved_slip(M within, const Line& line, V factor, V t, V beyond, V tolerance) const {
    const V guess = hn::Min(beyond, short_slip(line, factor, t));
    return find_root(
        within, select(within, positive_part(guess), beyond), zero(), beyond,
        splat(0.25) * tolerance, [&](V x, V & value, V & slope) __attribute__((always_inline)) {
          const V xi = hn::MulAdd(x, line.rate, line.xi);
          value = hn::NegMulAdd(p.ks, x, t) - line.at(f.factor(xi));
          slope = hn::Neg(hn::MulAdd(line.S_drop * line.rate, f.slope(xi), p.ks));
        });
  }
  // Slip under exponential softening: with x = rate gamma, D = S_drop f, k = ks/rate and c the excess of |tau*|,
  //   k x - D (1 - exp(-x)) = c.
  // Series in q = c/(k - D) up to the fourth power. It is exact to rounding for the short steps of an explicit
  // analysis, and a first guess for longer ones and for tables.
  HWY_INLINE V short_slip(const Line& line, V factor, V t) const {
    const V D = line.S_drop * factor * line.rate;
    const V inv_b = splat(1.0) / (p.ks - D);
    const V gamma = (t - line.at(factor)) * inv_b;
    if constexpr (Softening::kShape == Shape::table) return gamma;
    const V q = gamma * line.rate, r = D * inv_b;
    const V third = hn::MulAdd(splat(1.0 / 2.0), r, splat(1.0 / 6.0));
    const V fourth = hn::MulAdd(hn::MulAdd(splat(5.0 / 8.0), r, splat(5.0 / 12.0)), r, splat(1.0 / 24.0));
    const V bend = hn::MulAdd(hn::NegMulAdd(fourth, q, third), q, splat(-1.0 / 2.0));
    return hn::MulAdd(r * bend * q, gamma, gamma);
  }

  // ---- Closed, 3: pressure and slip over a seat that rises or falls -------------------------------------------------

  // Returns the pressure y/C, Pa. A residual opening resists a pressure of up to ft before it decreases.
  HWY_INLINE V pressure(const Step& s, V v) const {
    const V e = s.d_n - v + s.old.w;
    const V bare = positive_part((s.old.q - e) * s.crushed.E);
    if (none(s.old.q > zero())) return bare;
    const V rests = hn::Max(p.ft, zero() - e * s.crushed.E);
    return select(hn::Or(bare <= p.ft, s.old.q == zero()), bare, rests);
  }
  HWY_INLINE V pressure_slope(const Step& s, V v) const {  // dp/dy
    const V e = s.d_n - v + s.old.w;
    const M bare = hn::Or((s.old.q - e) * s.crushed.E <= p.ft, s.old.q == zero());
    const V y = select(bare, s.old.q - e, zero() - p.ft / s.crushed.E - e);
    return hn::IfThenElseZero(y >= zero(), s.crushed.E);
  }

  // Returns the slip at which a falling seat has released the pressure, but for a rounding that keeps the joint closed.
  // Infinite where the seat does not release it.
  HWY_INLINE V seat_stop(const Step& s) const {
    const State& old = s.old;
    const V along = hn::MulAdd(old.g_s, s.n_s, old.g_t * s.n_t);
    const V across = hn::MulSub(old.g_s, s.n_t, old.g_t * s.n_s);
    const V height = s.d_n + old.w - old.q, rounding = splat(0.5 * kYieldTolerance) * s.reach;
    const V r = old.r_m * ((height + rounding) / old.v_m);
    const V under = r * r - across * across;
    const M stops = hn::And(hn::And(old.v_m > zero(), along < zero()), hn::And(height > zero(), under >= zero()));
    return select(stops, positive_part(zero() - along - hn::Sqrt(positive_part(under))), splat(HUGE_VAL));
  }

  struct Seat {
    V g_s, g_t, r, v, v_slope;  // v_slope: dv/dr
    M moves, beyond;            // gamma < stop; r beyond its largest value so far
  };
  HWY_INLINE Seat seat(const Step& s, V gamma, V stop) const {
    const State& old = s.old;
    const V x = hn::Min(gamma, stop), one = splat(1.0);
    Seat a;
    a.g_s = hn::MulAdd(x, s.n_s, old.g_s), a.g_t = hn::MulAdd(x, s.n_t, old.g_t);
    a.r = hn::Sqrt(hn::MulAdd(a.g_s, a.g_s, a.g_t * a.g_t));
    a.moves = gamma < stop;
    a.v = on_ramp(old, a.r);
    a.v_slope = hn::IfThenZeroElse(old.r_m == zero(), old.v_m / old.r_m);
    a.beyond = hn::And(a.r > old.r_m, p.tan_psi > zero());
    if (!none(a.beyond)) {
      const V X = p.tan_psi * p.sd * f.area(old.r_m * p.inv_sd, a.r * p.inv_sd);
      const V share = positive_part(one - pressure(s, old.v_m) * p.inv_pd);
      const V eased = hn::MulAdd(X * s.crushed.E, p.inv_pd, one);
      a.v = select(a.beyond, old.v_m + X * share / eased, a.v);
      a.v_slope = select(a.beyond, p.tan_psi * f.factor(a.r * p.inv_sd) * share / (eased * eased), a.v_slope);
    }
    a.v_slope = hn::IfThenElseZero(hn::Or(a.beyond, a.r <= old.r_m), a.v_slope);
    return a;
  }
  HWY_INLINE V r_slope(const Step& s, const Seat& a) const {  // dr/dgamma
    const V along = hn::MulAdd(a.g_s, s.n_s, a.g_t * s.n_t);
    return hn::IfThenElseZero(a.moves, select(a.r > zero(), along / a.r, splat(1.0)));
  }

  // Solves t - ks gamma = c + mu min(p, F) for the slip gamma of a closed joint whose seat moves.
  HWY_NOINLINE V slip_on_seat(M slips, const Step& s, V xi, V stop, V tolerance) const {
    return find_root(slips, zero(), zero(), s.t * p.inv_ks, splat(0.25) * tolerance, [&](V gamma, V& value, V& slope) {
      const V x = hn::MulAdd(gamma, p.inv_su, xi);
      const V factor = f.factor(x);
      const Seat a = seat(s, gamma, stop);
      const V bare = pressure(s, a.v), held = hn::Min(bare, s.crushed.F);
      const V mu = hn::MulAdd(p.mu_drop, factor, p.mur);
      const V drop = hn::MulAdd(p.mu_drop, held, p.c_drop * s.crushed.b);
      value = hn::NegMulAdd(p.ks, gamma, s.t) - hn::MulAdd(drop, factor, hn::MulAdd(p.mur, held, p.cr));
      const V follows = hn::IfThenElseZero(bare < s.crushed.F, pressure_slope(s, a.v) * a.v_slope * r_slope(s, a));
      slope = hn::Neg(p.ks + hn::MulAdd(mu, follows, drop * p.inv_su * f.slope(x)));
    });
  }

  // ---- Closed, 4: the cap -------------------------------------------------------------------------------------------

  // Crushing by D: the pressure p and shear T1 before it become p1 = P F1 and tau1 = Q F1.
  struct Cap {
    V D, l, F1, F1_slope, P, Q;
    V inv_a, inv_k, a_rate, k_rate;  // a_rate, k_rate: a'/a, k'/k
  };
  HWY_INLINE static Cap either(M mask, const Cap& yes, const Cap& no) {
    const auto one = [&](V Cap::*member) { return select(mask, yes.*member, no.*member); };
    return {one(&Cap::D), one(&Cap::l),     one(&Cap::F1),    one(&Cap::F1_slope), one(&Cap::P),
            one(&Cap::Q), one(&Cap::inv_a), one(&Cap::inv_k), one(&Cap::a_rate),   one(&Cap::k_rate)};
  }
  HWY_INLINE Cap cap_at(const Step& s, V pressure, V T1, V D) const {
    Cap c;
    c.D = D;
    c.l = s.old.l + D;
    c.F1 = F(c.l), c.F1_slope = F_slope(c.l);
    const V C1 = C(c.l), E0 = s.crushed.E, shear = p.ks * p.Cs;
    const V a = (hn::MulAdd(c.F1, C1, D) - recovery(s.old.l, c.l)) * E0;
    const V k = hn::MulAdd(shear, D, c.F1);
    c.inv_a = splat(1.0) / a, c.inv_k = splat(1.0) / k;
    c.a_rate = (hn::MulAdd(c.F1_slope, C1, splat(1.0)) + p.half_chi * c.F1) * E0 * c.inv_a;
    c.k_rate = (c.F1_slope + shear) * c.inv_k;
    c.P = pressure * c.inv_a, c.Q = T1 * c.inv_k;
    return c;
  }
  HWY_INLINE V cap_fall(const Cap& c) const {  // derivative of -R^2/2 by D; R^2 = P^2 + Cs Q^2, 1 on the cap
    return hn::MulAdd(c.P * c.P, c.a_rate, p.Cs * (c.Q * c.Q) * c.k_rate);
  }
  // R - 1 and its slope, both times max(R^2, 1). Outside the cap Newton's step is then that of 1/R, which is nearly
  // linear in D. The division does not wait for the square root.
  struct Beyond {
    V value, slope;
  };
  HWY_INLINE Beyond beyond_cap(const Cap& c) const {
    const V one = splat(1.0), R_squared = hn::MulAdd(c.P, c.P, p.Cs * (c.Q * c.Q));
    const V fall = cap_fall(c) / hn::Min(R_squared, one);
    return {hn::Max(R_squared, one) * (hn::Sqrt(R_squared) - one), zero() - fall};
  }

  // True where N exceeds F by more than the tolerance.
  HWY_INLINE M outside_cap(const Step& s, V N) const { return N - s.crushed.F > s.tolerance(s.crushed.F); }
  HWY_INLINE V N_of(V pressure, V T1) const { return hn::Sqrt(hn::MulAdd(pressure, pressure, p.Cs * (T1 * T1))); }

  // Returns the crushing D > 0 with P^2 + Cs Q^2 = 1 for the active lanes outside the cap, and D = 0 for others.
  HWY_INLINE Cap crush(M active, const Step& s, V pressure, V T1) const {
    const V N = N_of(pressure, T1);
    const M outside = hn::And(active, outside_cap(s, N));
    // Newton's step from D = 0, in a form that holds also for F = 0.
    const V slope_0 = F_slope(s.old.l), shear = p.ks * p.Cs;
    const V a_slope = hn::MulAdd(slope_0, C(s.old.l), hn::MulAdd(p.half_chi, s.crushed.F, splat(1.0))) * s.crushed.E;
    const V rise = hn::MulAdd(pressure * pressure, a_slope, p.Cs * (T1 * T1) * (slope_0 + shear));
    const V guess = (N - s.crushed.F) * (N * N) / positive_part(rise);
    return crush_from(outside, s, pressure, T1, N, hn::IfThenElseZero(outside, guess));
  }
  // crush from a first guess of D. Lanes that are not active return their guess; a guess of NaN counts as none.
  HWY_INLINE Cap crush_from(M active, const Step& s, V pressure, V T1, V N, V guess) const {
    const V one = splat(1.0);
    const V highest = N / (s.crushed.E * hn::NegMulAdd(p.half_chi, p.fc, one));
    // P and Q of a joint without strength are not distinguished at D = 0.
    const V lowest = hn::IfThenElseZero(s.crushed.F == zero(), splat(0.5) * highest);
    Cap c;
    find_root(
        active, select(active, hn::Min(select(guess > zero(), guess, lowest), highest), guess), zero(), highest,
        splat(0.25) * s.tolerance(s.crushed.F) / N, [&](V D, V & value, V & slope) __attribute__((always_inline)) {
          c = cap_at(s, pressure, T1, D);
          const Beyond beyond = beyond_cap(c);
          value = beyond.value, slope = beyond.slope;
        });
    return c;
  }

  HWY_INLINE V crushing_by(const Cap& c, V P_by, V Q_by) const {  // dD for changes P_by, Q_by of P, Q at fixed D
    return hn::IfThenElseZero(c.D > zero(), hn::MulAdd(c.P, P_by, p.Cs * c.Q * Q_by) / cap_fall(c));
  }

  // J = (tau1 - c1 - mu p1)/F1 after crushing, the excess over the shear strength. Finite also at F1 = 0 if cr = 0.
  // J_D: dJ/dD. J_by, D_by: changes of J and D along the cap for changes p_by, T1_by and factor_by of p, T1 and f.
  struct Corner {
    V J, J_D, J_by, D_by;
  };
  HWY_INLINE Corner corner(const Cap& c, V factor, V p_by, V T1_by, V factor_by) const {
    const V mu = hn::MulAdd(p.mu_drop, factor, p.mur), inv_F1 = splat(1.0) / c.F1;
    const M past_peak = c.l > p.wp;
    const V residual = hn::IfThenElseZero(p.cr > zero(), p.cr * inv_F1);
    const V bonded = p.c_drop * select(past_peak, p.inv_fc, inv_F1);  // (c0 - cr) b1/F1
    const V P_by = p_by * c.inv_a, Q_by = T1_by * c.inv_k, D_by = crushing_by(c, P_by, Q_by);
    const V F_rate = hn::IfThenElseZero(c.F1 > zero(), c.F1_slope / c.F1);  // F1 may be too small for 1/F1
    Corner j;
    j.D_by = D_by;
    j.J = c.Q - residual - bonded * factor - mu * c.P;
    j.J_D = (residual + hn::IfThenZeroElse(past_peak, bonded * factor)) * F_rate + mu * c.P * c.a_rate - c.Q * c.k_rate;
    j.J_by = hn::MulAdd(j.J_D, D_by, Q_by - (bonded + p.mu_drop * c.P) * factor_by - mu * P_by);
    return j;
  }

  // ---- ORDER of the update ------------------------------------------------------------------------------------------

  // The joint after a slip of gamma, before the cap.
  struct Slid {
    V gamma, xi, factor, p, tau;
    Seat seat;
  };
  struct Course {
    Line line;       // strength along the slip; its xi: where the slip starts, for a cohesion without drop the end
    V factor_start;  // f where the slip starts
    V stop;          // seat_stop, m
    M slips, on_seat;
    bool any_on_seat;
  };
  HWY_INLINE Slid slide(const Step& s, const Course& c, V p_start, V gamma) const {
    Slid a{gamma, hn::MulAdd(gamma, c.line.rate, c.line.xi), c.factor_start, p_start, s.t, {}};
    a.factor = f.factor(a.xi);
    a.tau = c.line.at(a.factor);
    const V x = hn::Min(gamma, c.stop);
    a.seat.g_s = hn::MulAdd(x, s.n_s, s.old.g_s), a.seat.g_t = hn::MulAdd(x, s.n_t, s.old.g_t);
    a.seat.v = s.v;
    a.seat.beyond = hn::MaskFromVec(zero());
    a.seat.r = zero();
    if (c.any_on_seat) {
      const Seat on = seat(s, gamma, c.stop);
      a.seat.r = on.r, a.seat.v_slope = on.v_slope, a.seat.moves = on.moves;
      a.seat.v = select(c.on_seat, on.v, s.v);
      a.seat.beyond = hn::And(c.on_seat, on.beyond);
      a.p = select(c.on_seat, pressure(s, on.v), p_start);
      const V held = hn::Min(a.p, s.crushed.F), mu = hn::MulAdd(p.mu_drop, a.factor, p.mur);
      const V cohesion = hn::MulAdd(p.c_drop * s.crushed.b, a.factor, p.cr);
      a.tau = select(c.on_seat, hn::MulAdd(mu, held, cohesion), a.tau);
    }
    return a;
  }

  // Returns J after a slip of gamma and the crushing crushed, and its derivatives by the slip along the cap.
  HWY_INLINE Corner corner_after(const Step& s, const Course& c, V gamma, V factor, const Cap& crushed) const {
    V p_by = zero();
    if (c.any_on_seat) {
      const Seat a = seat(s, gamma, c.stop);
      p_by = hn::IfThenElseZero(c.on_seat, pressure_slope(s, a.v) * a.v_slope * r_slope(s, a));
    }
    const V factor_by = f.slope(hn::MulAdd(gamma, c.line.rate, c.line.xi)) * c.line.rate;
    return corner(crushed, factor, p_by, zero() - p.ks, factor_by);
  }

  // Slip and crushing that satisfy both the shear strength and the cap. meet: Newton's method for both unknowns, from
  // no slip. Lanes that it does not solve in eight steps, or whose result is inside the cap, take meet_in_bracket.
  struct Meeting {
    V gamma;
    Cap cap;
    M found;
  };
  HWY_INLINE Meeting meet(M slips, const Step& s, const Course& c, V p_start, V gamma_A, V tolerance,
                          const Corner& no_slip, const Cap& cap_no_slip) const {
    const auto within = [&](V gamma) { return hn::Min(positive_part(gamma), gamma_A); };
    Meeting m{within(zero() - no_slip.J / no_slip.J_by), cap_no_slip, Nowhere()};
    V D = positive_part(hn::MulAdd(no_slip.D_by, m.gamma, cap_no_slip.D));
    V N = zero();
    for (int step = 0; step < 8; ++step) {
      const Slid a = slide(s, c, p_start, m.gamma);
      const V T1 = hn::NegMulAdd(p.ks, m.gamma, s.t);
      N = N_of(a.p, T1);
      m.cap = cap_at(s, a.p, T1, D);
      const Corner j = corner_after(s, c, m.gamma, a.factor, m.cap);
      const Beyond beyond = beyond_cap(m.cap);
      m.found = hn::And(hn::Abs(beyond.value) <= tolerance, hn::Abs(j.J) <= tolerance);
      if (none(hn::AndNot(m.found, slips))) break;
      const V onto_cap = zero() - beyond.value / beyond.slope;
      const V gamma = within(m.gamma - hn::MulAdd(j.J_D, onto_cap, j.J) / j.J_by);
      D = select(m.found, D, positive_part(D + hn::MulAdd(j.D_by, gamma - m.gamma, onto_cap)));
      m.gamma = select(m.found, m.gamma, gamma);
    }
    m.found = hn::And(hn::And(m.found, m.gamma > zero()), outside_cap(s, N));
    return m;
  }
  HWY_NOINLINE Meeting meet_in_bracket(M slips, const Step& s, const Course& c, V p_start, V gamma_A, V tolerance,
                                       const Corner& no_slip, const Cap& cap_no_slip) const {
    const V guess = hn::Min(gamma_A, positive_part(zero() - no_slip.J / no_slip.J_by));
    // Each crushing starts from a linear extrapolation of the last one. A lane whose slip does not change keeps its
    // crushing.
    Meeting m{zero(), cap_no_slip, slips};
    V last = zero(), D_by = no_slip.D_by;
    m.gamma = find_root(slips, guess, zero(), gamma_A, tolerance, [&](V x, V& value, V& slope) {
      const Slid a = slide(s, c, p_start, x);
      const V T1 = hn::NegMulAdd(p.ks, x, s.t), N = N_of(a.p, T1);
      const M outside = hn::And(slips, outside_cap(s, N)), moved = x != last;
      const V first = select(moved, hn::MulAdd(D_by, x - last, m.cap.D), m.cap.D);
      m.cap = crush_from(hn::And(outside, moved), s, a.p, T1, N, hn::IfThenElseZero(outside, first));
      const Corner j = corner_after(s, c, x, a.factor, m.cap);
      value = j.J, slope = j.J_by;
      last = x, D_by = j.D_by;
    });
    return m;
  }

  // Step 4 for lanes outside the cap after slip gamma_A: crushes without slip, or with the slip at which shear strength
  // and cap meet.
  HWY_INLINE Cap cap(M capped, const Step& s, const Course& c, V p_start, V factor_no_slip, V& gamma) const {
    const Cap no_slip = crush(capped, s, p_start, s.t);
    const M may_slip = hn::And(capped, gamma > zero());
    if (none(may_slip)) return no_slip;
    const Corner J = corner_after(s, c, zero(), factor_no_slip, no_slip);
    const M slips = hn::And(may_slip, J.J > zero());
    const V gamma_A = hn::IfThenElseZero(slips, gamma);
    gamma = hn::IfThenZeroElse(capped, gamma);
    if (none(slips)) return no_slip;
    const V tolerance = splat(0.25) * s.tolerance(s.crushed.F) / N_of(p_start, s.t);
    Meeting m = meet(slips, s, c, p_start, gamma_A, tolerance, J, no_slip);
    const M left = hn::AndNot(m.found, slips);
    if (!none(left)) {
      const Meeting other = meet_in_bracket(left, s, c, p_start, gamma_A, tolerance, J, no_slip);
      m.gamma = select(left, other.gamma, m.gamma);
      m.cap = either(left, other.cap, m.cap);
    }
    gamma = select(slips, m.gamma, gamma);
    return either(slips, m.cap, no_slip);
  }

  // Steps 1 to 5 of the update. open: the joints with h > 0 by step 0, as a mask, or Nowhere or Everywhere for vectors
  // of joints that are not crushed. With these two types it returns false, without a result, if a lane slips on its
  // seat or meets the cap.
  template <bool kEnergies, bool kTangent, class Open>
  HWY_INLINE bool evaluate(const Step& s, Open open, Result& r, Energies* energies, Tangent* tangent) const {
    constexpr bool kPlain = !std::is_same_v<Open, M>;
    const State& old = s.old;
    const M nowhere = Nowhere();
    const auto closed = opposite(open);

    // Step 3 without slip
    const V p_start = only(closed, pressure(s, s.v));
    const V held = hn::Min(p_start, s.crushed.F);
    Course c;
    c.line = {old.xi, p.inv_su, hn::MulAdd(p.mur, held, p.cr), hn::MulAdd(p.mu_drop, held, p.c_drop * s.crushed.b)};
    Opening o{old.xi, old.kappa, old.q, s.h, zero(), zero(), zero(), nowhere};
    if (!none(open)) {  // step 1, and step 2 without slip
      o = opening<kEnergies>(s, open);
      c.line.xi = o.xi;
      c.line.rate = select(open, o.T * p.inv_c0_su, c.line.rate);
      c.line.S_end = unless(open, c.line.S_end);
      c.line.S_drop = select(open, s.crushed.b * o.T, c.line.S_drop);
    }
    const V factor_no_slip = f.factor(c.line.xi);
    const V S = c.line.at(factor_no_slip);
    const V tolerance = s.tolerance(S);
    c.slips = s.t - S > tolerance;
    c.stop = splat(HUGE_VAL);
    c.on_seat = nowhere;
    c.any_on_seat = false;

    // Slip: step 2 for open joints, gamma_A of step 3 for closed joints
    Slid a{zero(), o.xi, factor_no_slip, p_start, s.t, {old.g_s, old.g_t, zero(), s.v, zero(), nowhere, nowhere}};
    if (!none(c.slips)) {
      c.line.xi = hn::Max(c.line.xi, hn::IfThenElseZero(c.slips, p.xi_at_first_slip));
      c.factor_start = hn::IfThenElseZero(c.line.xi == o.xi, factor_no_slip);
      const auto on_seat = both(closed, hn::And(c.slips, hn::Or(p.tan_psi > zero(), old.v_m != zero())));
      c.on_seat = on_seat;
      c.any_on_seat = !none(on_seat);
      if (kPlain && c.any_on_seat) return false;
      V gamma = slip_to(hn::AndNot(c.on_seat, c.slips), c.line, c.factor_start, s.t, tolerance);
      if (!kPlain && c.any_on_seat) {
        c.stop = select(c.on_seat, seat_stop(s), c.stop);
        const Step kept = s;  // slip_on_seat takes the address of the copy, so that s stays in registers
        gamma = select(c.on_seat, slip_on_seat(c.on_seat, kept, c.line.xi, c.stop, tolerance), gamma);
      }
      a = slide(s, c, p_start, gamma);
      a.tau = select(c.slips, a.tau, s.t);
    }

    // Step 4
    r.crushes = nowhere;
    V p_end = a.p, l = old.l, w = old.w;
    Cap cap_end;
    const V N_squared = hn::MulAdd(a.p, a.p, p.Cs * (a.tau * a.tau));
    if (!none(both(closed, N_squared > s.crushed.F * s.crushed.F))) {
      const V T1 = hn::NegMulAdd(p.ks, a.gamma, s.t);
      r.crushes = both(closed, outside_cap(s, N_of(a.p, T1)));
      if (kPlain && !none(r.crushes)) return false;
      if (!kPlain && !none(r.crushes)) {
        V gamma = a.gamma;
        cap_end = cap(r.crushes, s, c, p_start, factor_no_slip, gamma);
        if (!none(c.slips)) {
          const Slid once_more = slide(s, c, p_start, gamma);
          const M stays = hn::And(r.crushes, gamma == zero());
          a.gamma = gamma;
          a.seat = once_more.seat;
          a.p = once_more.p;
          a.xi = select(stays, o.xi, once_more.xi);
          a.factor = select(stays, factor_no_slip, once_more.factor);
        }
        p_end = select(r.crushes, cap_end.P * cap_end.F1, a.p);
        a.tau = select(r.crushes, cap_end.Q * cap_end.F1, a.tau);
        l = select(r.crushes, cap_end.l, l);
        const V closure = cap_end.P * (cap_end.D - recovery(old.l, cap_end.l));
        w = select(r.crushes, old.w + closure, w);
      }
    }
    r.slips = hn::And(c.slips, a.gamma > zero());

    // Step 5
    const V e = s.d_n - a.seat.v + old.w;
    V q = o.q;
    r.gives_way = nowhere;
    if (!none(both(closed, old.q > zero()))) {
      const V given = hn::Min(old.q, positive_part(p.ft / s.crushed.E + e));
      const M rests = both(closed, hn::And(old.q > zero(), (old.q - e) * s.crushed.E > p.ft));
      q = select(rests, given, q);
      r.gives_way = both(closed, q < old.q);
    }
    r.opens = o.opens;
    r.reseats = a.seat.v < s.v;
    r.gamma = a.gamma;
    r.trial = s.t;
    r.sigma = select(open, s.crushed.b * a.factor * o.s0, zero() - p_end);
    State& now = r.state;
    now.xi = a.xi;
    now.kappa = select(o.opens, o.kappa, old.kappa);
    now.q = q;
    now.l = l;
    now.w = w;
    now.g_s = select(open, old.g_s, a.seat.g_s);
    now.g_t = select(open, old.g_t, a.seat.g_t);
    now.r_m = select(a.seat.beyond, a.seat.r, old.r_m);
    now.v_m = select(a.seat.beyond, a.seat.v, old.v_m);
    const M turned = hn::Or(c.slips, r.crushes);
    now.tau_s = select(turned, s.n_s * a.tau, s.trial_s);
    now.tau_t = select(turned, s.n_t * a.tau, s.trial_t);
    r.h = select(open, o.h, s.d_n - a.seat.v + w - q);
    r.used = hn::MulAdd(s.h + r.h, zero(), only(open, hn::IfThenZeroElse(old.xi == zero(), old.kappa * zero())));
    r.used = hn::MulAdd(old.xi + old.l, zero(), r.used);
    r.used = r.used + hn::IfThenElseZero(c.slips, (now.g_s + now.g_t + now.r_m + old.r_m) * zero());

    if constexpr (kEnergies) *energies = energies_of(s, open, o, c, a, r, p_end);
    if constexpr (kTangent) *tangent = tangent_of(s, open, o, c, a, r, cap_end);
    return true;
  }

  // ---- Energies -----------------------------------------------------------------------------------------------------

  HWY_NOINLINE Energies energies_of(const Step& s, M open, const Opening& o, const Course& c, const Slid& a,
                                    const Result& r, V pressure_end) const {
    const State &old = s.old, &now = r.state;
    const V half = splat(0.5), b = s.crushed.b;
    Energies E;
    const V tau_squared = hn::MulAdd(now.tau_s, now.tau_s, now.tau_t * now.tau_t);
    const V normal = select(open, r.sigma * r.h, pressure_end * pressure_end * C(now.l));
    E.stored = half * hn::MulAdd(tau_squared, p.inv_ks, normal);

    // b ft (f0 (kappa0 - q0) - f1 (kappa1 - q1)) without cancellation
    const V f0 = f.factor(old.xi), f1 = f.factor(o.xi);
    const V kappa0 = reached(old), longer = (o.kappa - kappa0) - (o.q - old.q);
    const V freed = f.drop(old.xi, o.xi) * (kappa0 - old.q) - f1 * longer;
    const V opening_work = b * p.ft * hn::MulAdd(half, freed, p.lt * o.passed);
    E.tension = hn::IfThenElseZero(o.opens, positive_part(opening_work));
    E.cohesion = zero(), E.friction = zero(), E.crushing = zero();
    const M slips = r.slips;
    if (!none(slips)) {
      const M starts_at_end = c.line.xi > o.xi;  // a cohesion without drop has no area
      const V area = hn::IfThenZeroElse(starts_at_end, f.area(c.line.xi, a.xi));
      const V dropped = select(starts_at_end, f1, f.drop(c.line.xi, a.xi));
      E.tension = E.tension + hn::IfThenElseZero(hn::And(open, slips), half * b * o.s0 * o.h * dropped);

      const V bond_end = bond(now.l, F(now.l));
      const V cohesive =
          select(open, b * p.c0 * p.su * area, hn::MulAdd(p.cr, r.gamma, p.c_drop * bond_end * p.su * area));
      const V held = hn::Min(hn::Sqrt(hn::MulAdd(old.tau_s, old.tau_s, old.tau_t * old.tau_t)), s.t);
      const V B = b * f1;
      const V residual = hn::Min(p.cr * (splat(1.0) - B), hn::NegMulAdd(B, o.T, held));
      const M by_opening = hn::And(hn::And(p.ft == zero(), f1 == zero()), f0 > zero());
      const M at_once = hn::Or(by_opening, hn::And(p.c0 == p.cr, f1 > zero()));
      const M drops = hn::AndNot(open, hn::And(slips, starts_at_end));  // friction that is lost at the first slip
      const V pressure_start = pressure(s, s.v);
      const V held_start = hn::Min(pressure_start, s.crushed.F), held_end = hn::Min(a.p, s.crushed.F);
      const V rise = hn::IfThenElseZero(drops, p.mur * (held_end - held_start) / r.gamma);  // of the strength, Pa/m
      const V lost = select(open, select(at_once, held, positive_part(residual)),
                            hn::IfThenElseZero(drops, p.mu_drop * f1 * held_start));
      E.cohesion = hn::IfThenElseZero(slips, cohesive + half * lost * lost / (p.ks + rise));

      const V mean = select(hn::AndNot(r.crushes, drops), half * (pressure_start + pressure_end), pressure_end);
      const V rubbed = hn::MulAdd(p.mu_drop, p.su * area, p.mur * r.gamma) - (a.seat.v - s.v);
      E.friction = hn::IfThenElseZero(hn::AndNot(open, slips), positive_part(mean * rubbed));
    }
    E.tension = hn::MulAdd(p.ft, hn::IfThenElseZero(r.gives_way, old.q - now.q), E.tension);
    if (!none(r.crushes)) E.crushing = hn::IfThenElseZero(r.crushes, positive_part(F_area(old.l, now.l)));
    return E;
  }

  // ---- Consistent tangent: implicit derivative of the end-of-step equations -----------------------------------------

  // Derivatives of sigma and |tau| by one of d_n, |tau*| and the angle of tau*.
  struct Change {
    V sigma, tau;
  };

  HWY_NOINLINE Tangent tangent_of(const Step& s, M open, const Opening& o, const Course& c, const Slid& a,
                                  const Result& r, const Cap& cap) const {
    const State& old = s.old;
    const V one = splat(1.0), f_slope = f.slope(a.xi);
    Change by[3];  // d_n, |tau*|, angle

    // Open
    const V width = o.kappa - o.q;
    const V q_n = hn::IfThenElseZero(o.opens, p.beta * p.lt * f.factor(o.xi) * p.inv_lt);
    const V h_n = one - q_n;
    const V s0_n =
        hn::IfThenElseZero(hn::AndNot(o.opens, p.ft > zero()), p.kn * (p.u0 / width) * h_n);  // on the envelope s0 = ft
    const V T_n = hn::IfThenElseZero(o.T > zero(), zero() - p.mu0 * s0_n);
    const V xi_n = hn::IfThenElseZero(o.opens, p.inv_lt);
    const V b = s.crushed.b;
    const V open_slope = p.ks + b * o.T * f_slope * c.line.rate;
    const V rate_n = T_n * p.inv_c0_su;
    const V open_n = b * hn::MulAdd(T_n, a.factor, o.T * f_slope * hn::MulAdd(rate_n, r.gamma, xi_n));
    // An open joint without strength slips by the least movement.
    const M slips = hn::Or(r.slips, hn::And(open, hn::Max(b * o.T * a.factor, s.t) == zero()));
    const V open_gamma[3] = {hn::IfThenElseZero(slips, zero() - open_n / open_slope),
                             hn::IfThenElseZero(slips, one / open_slope), zero()};

    // Closed
    const V E0 = s.crushed.E;
    V v_slip = zero(), v_n = zero(), v_turn = zero();
    if (c.any_on_seat) {
      const V turned = a.gamma * hn::MulSub(old.g_t, s.n_s, old.g_s * s.n_t) / a.seat.r;
      const V X = p.tan_psi * p.sd * f.area(old.r_m * p.inv_sd, a.seat.r * p.inv_sd);
      const M fades = hn::And(a.seat.beyond, pressure(s, old.v_m) * p.inv_pd < one);
      const V by_pressure = X * p.inv_pd * pressure_slope(s, old.v_m) / hn::MulAdd(X * E0, p.inv_pd, one);
      v_slip = hn::IfThenElseZero(c.on_seat, a.seat.v_slope * r_slope(s, a.seat));
      v_n = hn::IfThenElseZero(c.on_seat, select(a.seat.moves, hn::IfThenElseZero(fades, by_pressure), one));
      v_turn =
          hn::IfThenElseZero(hn::And(c.on_seat, hn::And(a.seat.moves, a.seat.r > zero())), a.seat.v_slope * turned);
    }
    const V p_y = pressure_slope(s, a.seat.v);
    const V p_slip = p_y * v_slip;
    const V p_by[3] = {p_y * (v_n - one), zero(), p_y * v_turn};
    const V mu = hn::MulAdd(p.mu_drop, a.factor, p.mur);
    const V drop = hn::MulAdd(p.mu_drop, a.p, p.c_drop * b);
    const V closed_slope = p.ks + hn::MulAdd(mu, p_slip, drop * f_slope * c.line.rate);
    V J_slip = one;
    const bool any_crush = !none(r.crushes);
    if (any_crush) J_slip = corner(cap, a.factor, p_slip, zero() - p.ks, f_slope * c.line.rate).J_by;

    for (int k = 0; k < 3; ++k) {
      const V t_by = k == 1 ? one : zero();
      V gamma = hn::IfThenElseZero(r.slips, (t_by - mu * p_by[k]) / closed_slope);
      if (any_crush) {
        const V meets = zero() - corner(cap, a.factor, p_by[k], t_by, zero()).J_by / J_slip;
        gamma = select(r.crushes, hn::IfThenElseZero(r.slips, meets), gamma);
      }
      const V p_total = hn::MulAdd(p_slip, gamma, p_by[k]), T1_total = hn::NegMulAdd(p.ks, gamma, t_by);
      by[k] = {zero() - p_total, T1_total};
      if (any_crush) {
        const V P_by = p_total * cap.inv_a, Q_by = T1_total * cap.inv_k, D_by = crushing_by(cap, P_by, Q_by);
        const V F_by = cap.F1_slope * D_by;
        const V p_by_k = hn::MulAdd(cap.P, F_by, cap.F1 * (P_by - cap.P * cap.a_rate * D_by));
        const V tau_by_k = hn::MulAdd(cap.Q, F_by, cap.F1 * (Q_by - cap.Q * cap.k_rate * D_by));
        by[k].sigma = select(r.crushes, zero() - p_by_k, by[k].sigma);
        by[k].tau = select(r.crushes, tau_by_k, by[k].tau);
      }
      const V rate_by = k == 0 ? hn::MulAdd(rate_n, r.gamma, xi_n) : zero();
      const V xi_by = hn::MulAdd(c.line.rate, open_gamma[k], rate_by);
      const V sigma_open = b * hn::MulAdd(f_slope * xi_by, o.s0, k == 0 ? a.factor * s0_n : zero());
      by[k].sigma = select(open, sigma_open, by[k].sigma);
      by[k].tau = select(open, hn::NegMulAdd(p.ks, open_gamma[k], t_by), by[k].tau);
    }

    // delta tau = n (by d_n, by ks n.d, by the angle ks e.d/t) + tau e ks e.d/t, e = (-n_t, n_s)
    const M turned = hn::Or(slips, r.crushes);
    const V inv_t = hn::IfThenElseZero(s.t > zero(), one / s.t);
    const V across = select(turned, select(s.t > zero(), a.tau * inv_t, by[1].tau), one);
    const V spread = hn::IfThenElseZero(turned, by[1].tau - across);
    const V twist = by[2].tau * inv_t, shear_n = by[0].tau, e_s = zero() - s.n_t, e_t = s.n_s;
    Tangent t;
    t.entry[0] = by[0].sigma;
    t.entry[1] = p.ks * hn::MulAdd(by[1].sigma, s.n_s, by[2].sigma * inv_t * e_s);
    t.entry[2] = p.ks * hn::MulAdd(by[1].sigma, s.n_t, by[2].sigma * inv_t * e_t);
    t.entry[3] = shear_n * s.n_s;
    t.entry[4] = p.ks * (across + s.n_s * hn::MulAdd(spread, s.n_s, twist * e_s));
    t.entry[5] = p.ks * (s.n_s * hn::MulAdd(spread, s.n_t, twist * e_t));
    t.entry[6] = shear_n * s.n_t;
    t.entry[7] = p.ks * (s.n_t * hn::MulAdd(spread, s.n_s, twist * e_s));
    t.entry[8] = p.ks * (across + s.n_t * hn::MulAdd(spread, s.n_t, twist * e_t));
    const M crushed_out = hn::AndNot(open, s.crushed.F == zero());  // no pressure beyond a rounding, on either side
    for (V& entry : t.entry) entry = hn::IfThenZeroElse(crushed_out, entry);
    return t;
  }
};

}  // namespace quoin::cyclic_joint::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
