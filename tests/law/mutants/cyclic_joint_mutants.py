"""Faults in the cyclic joint law: name -> (what is wrong, [(file, text, replacement)]), as in run_mutants.py."""
EQUATIONS = "cyclic_joint/equations.h"

MUTANTS = {
    "opening_damage_not_shared": (
        "slip does not damage the bond: tension keeps its strength",
        [(EQUATIONS, "now.xi = a.xi;", "now.xi = o.xi;")],
    ),
    "no_residual_opening": (
        "unloading goes to the origin, whatever beta",
        [(EQUATIONS, "o.q = hn::MulAdd(p.beta * p.lt, o.passed, old.q);", "o.q = old.q;")],
    ),
    "crumbs_hold": (
        "the residual opening does not give way at ft",
        [(EQUATIONS, "const V rests = hn::Max(p.ft, zero() - e * s.crushed.E);", "const V rests = bare;"),
         (EQUATIONS, "q = select(rests, given, q);", "")],
    ),
    "uplift_stays_on_return": (
        "faces stay up when slip comes back",
        [(EQUATIONS, "s.v_m * hn::IfThenZeroElse(s.r_m == zero(), hn::Min(splat(1.0), r / s.r_m));",
          "s.v_m * hn::IfThenZeroElse(s.r_m == zero(), splat(1.0) + zero() * r);")],
    ),
    "dilation_without_pressure": (
        "dilation does not fade with pressure",
        [(EQUATIONS, "const V share = positive_part(one - pressure(s, old.v_m) * p.inv_pd);", "const V share = one;")],
    ),
    "dilation_pressure_of_the_end_forgotten": (
        "the pressure that uplift adds does not fade it",
        [(EQUATIONS, "const V eased = hn::MulAdd(X * s.crushed.E, p.inv_pd, one);", "const V eased = one;")],
    ),
    "dilation_does_not_fade_with_slip": (
        "uplift tan(psi0) r for ever",
        [(EQUATIONS, "const V X = p.tan_psi * p.sd * f.area(old.r_m * p.inv_sd, a.r * p.inv_sd);",
          "const V X = p.tan_psi * (a.r - old.r_m);")],
    ),
    "seat_runs_on_without_contact": (
        "a falling seat does not stop where the pressure is 0",
        [(EQUATIONS, "return select(stops, positive_part(zero() - along - hn::Sqrt(positive_part(under))), splat(HUGE_VAL));",
          "return select(stops, splat(HUGE_VAL), splat(HUGE_VAL));")],
    ),
    "cap_not_associated": (
        "crushing flows along the pressure alone: shear does not relax by it",
        [(EQUATIONS, "const V k = hn::MulAdd(shear, D, c.F1);", "const V k = c.F1;"),
         (EQUATIONS, "c.k_rate = (c.F1_slope + shear) * c.inv_k;", "c.k_rate = c.F1_slope * c.inv_k;")],
    ),
    "cap_at_the_old_l": (
        "crushing strength at the start of the step",
        [(EQUATIONS, "c.F1 = F(c.l), c.F1_slope = F_slope(c.l);", "c.F1 = s.crushed.F, c.F1_slope = zero();")],
    ),
    "closure_without_recovery": (
        "w = l, whatever compliance crushing adds",
        [(EQUATIONS, "const V closure = cap_end.P * (cap_end.D - recovery(old.l, cap_end.l));",
          "const V closure = cap_end.P * cap_end.D;")],
    ),
    "crushing_keeps_the_bond": (
        "cohesion and ft of a crushed joint stay",
        [(EQUATIONS, "select(softens, strength * p.inv_fc, splat(1.0))", "select(softens, splat(1.0), splat(1.0))")],
    ),
    "corner_returns_to_the_old_pressure": (
        "a slip that ends on the cap keeps gamma_A",
        [(EQUATIONS, "gamma = select(slips, m.gamma, gamma);", "gamma = select(slips, gamma_A, gamma);")],
    ),
    "rising_function_stops_the_root": (
        "Newton walks from the upper end away from the root and stops there",
        [("shim/root.h", "const M leads = hn::AndNot(hn::Gt(slope, zero()), hn::Gt(newton, low));",
          "const M leads = hn::Gt(newton, low);")],
    ),
    "open_slip_costs_as_closed": (
        "an open slip spends su whatever tension does to its strength",
        [(EQUATIONS, "c.line.rate = select(open, o.T * p.inv_c0_su, c.line.rate);", "")],
    ),
    "stiffness_bound_kn": (
        "the bound of an open joint that slides is left out",
        [("cyclic_joint/plugin.cpp", "normal = g.kn * std::max(closed, open);", "normal = g.kn * closed; (void)open;")],
    ),
}
