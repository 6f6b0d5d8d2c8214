// The loop over points around the equations, compiled for every instruction set.
#include "fracture_energy/kernel.h"

#include <new>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fracture_energy/kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "fracture_energy/equations.h"
#include "shim/friction_column.h"
#include "shim/loop.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::fracture_energy::HWY_NAMESPACE {
using namespace quoin::shim;

HWY_INLINE Lanes material_lanes(const Parameters& m) {
  const Properties& g = m.given;
  return Lanes(m, splat(g.kn), splat(g.ks), splat(g.ft), splat(g.c0), splat(g.cr), splat(g.mu0), splat(g.mur),
               splat(g.tan_psi), splat(g.fc), splat(g.fcr), splat(g.G1), splat(g.G2), splat(g.Gc));
}

// Sets p to the properties of the points from i on: columns where given, the material's values elsewhere. On entry p
// has the material's values, or those of other points: members that depend on no column do not change.
HWY_INLINE void put_columns(const Parameters& m, const Lanes& own, const Columns& c, std::size_t i, Lanes& p) {
  const auto given = [&](int k) { return c.in[kProperty + k] != nullptr; };
  const auto put = [&](int k, V& value) HWY_ATTR {
    if (given(k)) value = load(c.in[kProperty + k], i);
  };
  V G1 = splat(m.given.G1), G2 = splat(m.given.G2), Gc = splat(m.given.Gc);
  put(kColumnKn, p.kn), put(kColumnKs, p.ks), put(kColumnFt, p.ft), put(kColumnC0, p.c0), put(kColumnCr, p.cr);
  put(kColumnFc, p.fc), put(kColumnFcr, p.fcr), put(kColumnG1, G1), put(kColumnG2, G2), put(kColumnGc, Gc);
  if (given(kColumnPhi0)) {
    p.mu0 = friction_column(c.in[kProperty + kColumnPhi0], i, own.mu0);
    p.mur = residual_friction(m.given.mur, m.own_mur, p.mu0);
  }
  if (given(kColumnPhir)) p.mur = friction_column(c.in[kProperty + kColumnPhir], i, own.mur);
  if (given(kColumnPsi0)) p.tan_psi = friction_column(c.in[kProperty + kColumnPsi0], i, own.tan_psi);
  if (given(kColumnKn) || given(kColumnFc) || given(kColumnFcr) || given(kColumnGc)) p.derive_crushing(m, Gc);
  p.derive(m, G1, G2);
}

// Preparation of a vector: fills in lanes from the property columns.
struct Refill {
  const Parameters& parameters;
  const Lanes& own;
  const Columns& columns;
  Lanes* lanes;  // null: no property columns, and the law reads the material's lanes

  HWY_INLINE void operator()(std::size_t i) const {
    if (lanes) fill(i);
  }
  HWY_NOINLINE void fill(std::size_t i) const { put_columns(parameters, own, columns, i, *lanes); }
};

// Strengths, energies and stiffnesses by point for the short path: one division in place of the seven of Lanes::derive.
// Its test of admissibility is on the safe side; a vector that fails it takes the whole step, which decides.
class QuickColumns {
 public:
  // True if no column is given that needs Lanes::derive.
  static bool serve(const Material& material, const Columns& c) {
    const auto given = [&](int k) { return c.in[kProperty + k] != nullptr; };
    const bool others = given(kColumnPhi0) || given(kColumnPhir) || given(kColumnPsi0) || given(kColumnFc) ||
                        given(kColumnFcr) || given(kColumnGc);
    return !others && !(given(kColumnKn) && material.parameters.dilation);
  }

  HWY_INLINE QuickColumns(const Parameters& m, const Lanes& own, const Columns& c)
      : own_(own), A_(splat(m.A)), slope_(splat(m.slope)) {
    const auto use = [&](int k, V value) HWY_ATTR {
      Source& s = source_[k];
      hn::StoreU(value, D(), s.own);
      s.from = c.in[kProperty + k] ? c.in[kProperty + k] : s.own;
      s.mask = c.in[kProperty + k] ? ~std::size_t{0} : 0;
    };
    use(kColumnKn, own.kn), use(kColumnKs, own.ks), use(kColumnFt, own.ft), use(kColumnC0, own.c0);
    use(kColumnCr, own.cr), use(kColumnG1, splat(m.given.G1)), use(kColumnG2, splat(m.given.G2));
  }

  // Sets the members of p that Equations::elastic reads, for the points from i on. Returns true if all are admissible.
  HWY_INLINE bool sound(std::size_t i, Lanes& p) const {
    const V kn = at(kColumnKn, i), ks = at(kColumnKs, i), ft = at(kColumnFt, i);
    const V c0 = at(kColumnC0, i), cr = at(kColumnCr, i), G1 = at(kColumnG1, i), G2 = at(kColumnG2, i);
    p.kn = kn, p.ks = ks;
    p.c_drop = hn::Sub(c0, cr);
    p.mu_drop = own_.mu_drop, p.mur = own_.mur;
    p.fc_drop = own_.fc_drop, p.fcr = own_.fcr, p.inv_wu = own_.inv_wu;
    p.u0 = hn::Div(ft, kn);

    const V sum = hn::Add(hn::Add(hn::Add(kn, ks), hn::Add(ft, c0)), hn::Add(hn::Add(cr, G1), G2));
    const V least = hn::Min(hn::Min(ft, cr), hn::Min(G1, G2));
    M sound = hn::And(is_finite(gather_non_finite(sum, zero())), hn::Ge(least, zero()));
    sound = hn::And(sound, hn::And(hn::Gt(hn::Min(kn, ks), zero()), hn::Le(cr, c0)));
    // The conditions of Lanes::derive against snap-back, multiplied by their divisors. Margins cover rounding and
    // underflow.
    const V rest = hn::NegMulAdd(hn::Mul(splat(0.5), ft), p.u0, G1);
    sound = hn::And(sound, hn::Or(hn::Gt(rest, hn::Mul(ft, splat(1e-280))), hn::Eq(ft, zero())));
    const V by_uplift = hn::Mul(kn, hn::Mul(hn::Mul(own_.mu0, own_.tan_psi), own_.uplift_crushes));
    const V pressure = hn::IfThenElseZero(hn::Lt(own_.fc, splat(HUGE_VAL)), own_.fc);
    const V steepest = hn::Mul(slope_, hn::Max(c0, hn::MulAdd(pressure, own_.mu_drop, p.c_drop)));
    const V needed = hn::Mul(hn::Mul(hn::Mul(p.c_drop, A_), splat(1.0 + 1e-9)), steepest);
    sound = hn::And(sound, hn::Or(hn::Gt(hn::Mul(G2, hn::Sub(ks, by_uplift)), needed), hn::Eq(p.c_drop, zero())));
    const M crushing = hn::Gt(hn::Mul(own_.wu, kn), hn::Mul(slope_, own_.fc_drop));
    return all(hn::And(sound, hn::Or(crushing, hn::Eq(own_.wu, zero()))));
  }

 private:
  // A column, or the material's value for every point.
  struct Source {
    const double* from;
    std::size_t mask;
    double own[kMaxLanes];
  };
  HWY_INLINE V at(int k, std::size_t i) const { return load(source_[k].from, i & source_[k].mask); }

  const Lanes& own_;
  const V A_, slope_;
  Source source_[kPropertyColumnCount];
};

// True where an internal variable moves: xi_s and v move with slip, w with crushing. A joint without strength opens at
// no change of xi_t.
HWY_INLINE M moved(const Result& r, const State& old) {
  return hn::Or(hn::Gt(r.state.xi_t, old.xi_t), hn::Or(r.slips, r.crushes));
}

HWY_INLINE V flags_of(const Lanes& p, const Result& r, const State& old) {
  const State& s = r.state;
  V flags = flag_if(hn::Gt(r.e, zero()), QUOIN_FLAG_OPEN);
  flags = hn::Add(flags, flag_if(r.slips, QUOIN_FLAG_SLIPPING));
  flags = hn::Add(flags, flag_if(hn::Gt(s.xi_t, zero()), QUOIN_FLAG_TENSION_DAMAGED));
  flags = hn::Add(flags, flag_if(hn::Ge(s.xi_t, p.end), QUOIN_FLAG_TENSION_COMPLETE));
  flags = hn::Add(flags, flag_if(hn::Gt(s.xi_s, zero()), QUOIN_FLAG_SHEAR_DAMAGED));
  flags = hn::Add(flags, flag_if(hn::Ge(s.xi_s, p.end), QUOIN_FLAG_SHEAR_COMPLETE));
  flags = hn::Add(flags, flag_if(hn::Gt(s.w, zero()), QUOIN_FLAG_CRUSHED));
  const M softens = hn::Gt(p.wu, zero());
  const M crushed_out = hn::And(softens, hn::Ge(hn::Mul(s.w, p.inv_wu), p.end));
  flags = hn::Add(flags, flag_if(crushed_out, QUOIN_FLAG_CRUSHING_COMPLETE));
  return hn::Add(flags, flag_if(moved(r, old), QUOIN_FLAG_YIELDING));
}

// Returns D = 1 - f of a mode: the lost share of ft, c0 - cr or fc - fcr.
template <class Law>
HWY_INLINE V damage_of(const Law& law, const State& s, int mode) {
  const V xi = mode == QUOIN_DAMAGE_TENSION    ? s.xi_t
               : mode == QUOIN_DAMAGE_COHESION ? s.xi_s
                                               : hn::Mul(s.w, law.p.inv_wu);
  return positive_part(hn::Sub(splat(1.0), law.f.factor(xi)));
}

// Reads and writes the columns of the points from i on through Access.
template <class Access>
struct At {
  const Columns& c;
  std::size_t i;

  HWY_INLINE V in(int k) const { return Access::load(c.in[k], i); }
  HWY_INLINE void out(int k, V value) const { Access::store(value, c.out[k], i); }

  HWY_INLINE Increment increment() const { return {in(kNormalJump), in(kSlipIncrement), in(kSlipIncrement + 1)}; }
  template <bool kShared>
  HWY_INLINE State state() const {
    const V xi_t = in(kStateOld + kXiT), xi_s = kShared ? xi_t : in(kStateOld + kXiS);
    return {xi_t,
            xi_s,
            in(kStateOld + kW),
            in(kStateOld + kV),
            in(kTractionOld + 1),
            in(kTractionOld + 2),
            in(kTractionOld)};
  }
  HWY_INLINE void put_traction(const Result& r) const {
    out(kTractionNew, r.sigma);
    out(kTractionNew + 1, r.state.tau_s);
    out(kTractionNew + 2, r.state.tau_t);
  }
  HWY_INLINE void put_history(const State& s) const {
    out(kStateNew + kXiT, s.xi_t);
    out(kStateNew + kXiS, s.xi_s);
    out(kStateNew + kW, s.w);
    out(kStateNew + kV, s.v);
  }
  HWY_INLINE void put_slip(V slip) const {
    if (c.out[kStateNew + kSlip]) out(kStateNew + kSlip, hn::Add(in(kStateOld + kSlip), slip));
  }
};

template <bool kFull, class Access, class Law>
HWY_INLINE void step_vector(const Law& law, const Columns& c, std::size_t i, std::size_t count, Summary& summary) {
  const Lanes& p = law.p;
  const At<Access> at{c, i};
  const Increment in = at.increment();
  const State old = at.template state<Law::kSharedDamage>();
  Energies energies;
  Tangent tangent;
  Result r = law.template evaluate<kFull, kFull>(in, old, &energies, &tangent);

  // One test for the whole vector: a value that is not finite, in or out, fails its point, whose outputs are the old
  // state. Old values are tested too, since min and max inside the equations may drop a NaN. e covers d_n, w and v.
  // |tau*| covers the old shear traction and the slip increment, and also overflow.
  V collected = gather_non_finite(old.xi_t, hn::Mul(r.e, zero()));
  if constexpr (!Law::kSharedDamage) {
    collected = gather_non_finite(old.xi_s, gather_non_finite(r.state.xi_t, collected));
  }
  collected = gather_non_finite(r.state.xi_s, gather_non_finite(r.trial, gather_non_finite(r.sigma, collected)));
  const M sound = hn::And(is_finite(collected), p.admissible);
  if (!all(sound)) {
    r.sigma = select(sound, r.sigma, at.in(kTractionOld));
    r.state.tau_s = select(sound, r.state.tau_s, at.in(kTractionOld + 1));
    r.state.tau_t = select(sound, r.state.tau_t, at.in(kTractionOld + 2));
    r.state.xi_t = select(sound, r.state.xi_t, old.xi_t);
    r.state.xi_s = select(sound, r.state.xi_s, at.in(kStateOld + kXiS));
    r.state.w = select(sound, r.state.w, old.w);
    r.state.v = select(sound, r.state.v, old.v);
    r.slip = hn::IfThenElseZero(sound, r.slip);
    r.slips = hn::And(sound, r.slips);
    summary.failed += hn::CountTrue(D(), hn::AndNot(sound, hn::FirstN(D(), count - i)));
  }

  if (!summary.yielding) summary.yielding = !none(hn::And(sound, moved(r, old)));
  at.put_slip(r.slip);
  if constexpr (kFull) {
    put_extras(
        c, i, sound, energies, tangent, [&] { return flags_of(p, r, old); },
        [&](int mode) { return damage_of(law, r.state, mode); });
  }
  at.put_traction(r);
  at.put_history(r.state);
}

template <class Law>
HWY_INLINE const Law& short_path(const Law& law) {
  return law;
}

template <class Access, class Law>
HWY_INLINE bool step_elastic(const Law& law, const Columns& c, std::size_t i) {
  const At<Access> at{c, i};
  const State old = at.template state<Law::kSharedDamage>();
  Result r;
  if (!law.template elastic<Access::kOnePoint>(at.increment(), old, r)) return false;
  if (!c.in_place) {
    at.put_history(r.state);
    at.put_slip(zero());
  }
  at.put_traction(r);
  return true;
}

HWY_INLINE const Lanes& own_lanes(const Material& material) { return *reinterpret_cast<const Lanes*>(material.lanes); }

template <class Softening, bool kShared, bool kCrushing, bool kDilation, bool kFull>
void run(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  using Law = Equations<Softening, kShared, kCrushing, kDilation>;
  const Columns own = c;  // a copy, which stays in registers: the compiler must assume that a store changes c
  const Lanes& lanes = own_lanes(material);
  Lanes by_point;
  if (own.property_columns) by_point = lanes;
  const Law law{own.property_columns ? by_point : lanes, Softening(material.parameters)};
  const Refill refill{material.parameters, lanes, own, own.property_columns ? &by_point : nullptr};
  if constexpr (kFull) {
    run_full(law, c, count, summary, refill);
  } else if (!own.property_columns) {
    const auto elastic = [&](std::size_t i) HWY_ATTR { return step_elastic<Vectors>(law, own, i); };
    run_lean(law, c, count, elastic, refill, summary);
  } else if (QuickColumns::serve(material, own)) {
    const QuickColumns quick(material.parameters, lanes, own);
    const auto elastic = [&](std::size_t i) HWY_ATTR {
      Lanes p;
      return quick.sound(i, p) && step_elastic<Vectors>(Law{p, law.f}, own, i);
    };
    run_lean(law, c, count, elastic, refill, summary);
  } else {
    const auto elastic = [&](std::size_t i) HWY_ATTR {
      refill(i);
      return all(by_point.admissible) && step_elastic<Vectors>(law, own, i);
    };
    run_lean(law, c, count, elastic, refill, summary);
  }
}

template <class Softening, bool kShared, bool kCrushing, bool kDilation>
void run_one(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  const Equations<Softening, kShared, kCrushing, kDilation> law{own_lanes(material), Softening(material.parameters)};
  run_one(law, c, count, summary);
}

// The full kernel always has the general branches. With parameters that switch a branch off its results are bitwise
// identical to those without the branch. One kernel is a quarter of the code.
template <class Softening, bool kShared>
void choose_branches(Material& m) {
  if (m.parameters.dilation) {
    m.lean = &run<Softening, kShared, true, true, false>;
    m.one = &run_one<Softening, kShared, true, true>;
  } else if (m.parameters.crushing) {
    m.lean = &run<Softening, kShared, true, false, false>;
    m.one = &run_one<Softening, kShared, true, false>;
  } else {
    m.lean = &run<Softening, kShared, false, false, false>;
    m.one = &run_one<Softening, kShared, false, false>;
  }
  m.full = &run<Softening, kShared, true, true, true>;
}

template <bool kShared>
void choose_shape(Material& m) {
  switch (m.parameters.shape) {
    case Shape::linear:
      return choose_branches<LinearSoftening, kShared>(m);
    case Shape::exponential:
      return choose_branches<ExponentialSoftening, kShared>(m);
    case Shape::table:
      return choose_branches<TableSoftening, kShared>(m);
  }
}

void choose_for_target(Material& m) {
  static_assert(sizeof(Lanes) <= sizeof m.lanes && alignof(Lanes) <= alignof(Material));
  static_assert(std::is_trivially_copyable_v<Lanes>);
  Lanes& lanes = *new (m.lanes) Lanes(material_lanes(m.parameters));
  lanes.admissible = hn::Eq(zero(), zero());  // make() has refused all other materials
  m.parameters.shared ? choose_shape<true>(m) : choose_shape<false>(m);
}

}  // namespace quoin::fracture_energy::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin::fracture_energy {

HWY_EXPORT(choose_for_target);

void choose_kernels(Material& material) { HWY_DYNAMIC_DISPATCH(choose_for_target)(material); }

}  // namespace quoin::fracture_energy
#endif
