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

// Per-point properties where a column is given, the material's value elsewhere. Without a column of their own the
// residual friction follows the friction column down, as its default does.
inline Lanes column_lanes(const Parameters& m, const Columns& c, std::size_t i) {
  const Properties& g = m.given;
  const auto number = [&](int k, double value) {
    const double* column = c.in[kProperty + k];
    return column == nullptr ? splat(value) : load(column, i);
  };
  const V mu0 = friction_column(c.in[kProperty + kColumnPhi0], i, splat(g.mu0));
  const V mur = friction_column(c.in[kProperty + kColumnPhir], i, hn::Min(splat(g.mur), mu0));
  const V tan_psi = friction_column(c.in[kProperty + kColumnPsi0], i, splat(g.tan_psi));
  return Lanes(m, number(kColumnKn, g.kn), number(kColumnKs, g.ks), number(kColumnFt, g.ft), number(kColumnC0, g.c0),
               number(kColumnCr, g.cr), mu0, mur, tan_psi, number(kColumnFc, g.fc), number(kColumnFcr, g.fcr),
               number(kColumnG1, g.G1), number(kColumnG2, g.G2), number(kColumnGc, g.Gc));
}

HWY_INLINE V flags_of(const Lanes& p, const Result& r, const State& old) {
  const State& s = r.state;
  const M moved = hn::Or(hn::Or(hn::Gt(s.xi_t, old.xi_t), hn::Gt(s.xi_s, old.xi_s)),
                         hn::Or(hn::Gt(s.w, old.w), hn::Or(r.slips, hn::Gt(s.v, old.v))));
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
  return hn::Add(flags, flag_if(moved, QUOIN_FLAG_YIELDING));
}

// D = 1 - f of each mode: the share of ft, of c0 - cr and of fc - fcr that is lost.
template <class Law>
HWY_INLINE V damage_of(const Law& law, const State& s, int mode) {
  const V xi = mode == QUOIN_DAMAGE_TENSION    ? s.xi_t
               : mode == QUOIN_DAMAGE_COHESION ? s.xi_s
                                               : hn::Mul(s.w, law.p.inv_wu);
  return positive_part(hn::Sub(splat(1.0), law.f.factor(xi)));
}

// The points from i on in the columns, as Access reaches them.
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

template <bool kFull, bool kColumns, class Access, class Law>
HWY_INLINE void step_vector(const Law& law, const Columns& c, std::size_t i, std::size_t count, Summary& summary) {
  const Lanes& p = law.p;
  const At<Access> at{c, i};
  const Increment in = at.increment();
  const State old = at.template state<Law::kSharedDamage>();
  Energies energies;
  Tangent tangent;
  Result r = law.template evaluate<kFull, kFull>(in, old, &energies, &tangent);

  // One test for the whole vector: not a number anywhere in or out fails the point, outputs equal the old state. Old
  // values too: a minimum or maximum inside the equations may lose one that is not a number. e tells of d_n, w and v,
  // |tau*| of all that slides, also where it is beyond the largest number.
  V collected = gather_non_finite(old.xi_t, hn::Mul(r.e, zero()));
  if constexpr (!Law::kSharedDamage) {
    collected = gather_non_finite(old.xi_s, gather_non_finite(r.state.xi_t, collected));
  }
  collected = gather_non_finite(r.state.xi_s, gather_non_finite(r.trial, gather_non_finite(r.sigma, collected)));
  M sound = is_finite(collected);
  if constexpr (kColumns) sound = hn::And(sound, p.admissible);
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

  if (!summary.yielding) summary.yielding = !none(hn::And(sound, hn::Or(hn::Or(r.opens, r.slips), r.crushes)));
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

template <class Softening, bool kShared, bool kCrushing, bool kDilation, bool kFull, bool kColumns>
void run(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  Lanes point_lanes;
  const Lanes& p = kColumns ? point_lanes : *reinterpret_cast<const Lanes*>(material.lanes);
  const Equations<Softening, kShared, kCrushing, kDilation> law{p, Softening(material.parameters)};
  if constexpr (kFull) {
    run_full<kColumns>(law, c, count, summary, [&](std::size_t i) {
      if constexpr (kColumns) point_lanes = column_lanes(material.parameters, c, i);
    });
  } else {
    run_lean(law, c, count, summary);
  }
}

template <class Softening, bool kShared, bool kCrushing, bool kDilation>
void run_one(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  const Lanes& p = *reinterpret_cast<const Lanes*>(material.lanes);
  const Equations<Softening, kShared, kCrushing, kDilation> law{p, Softening(material.parameters)};
  run_one(law, c, count, summary);
}

// Extra outputs and columns always take the general branches: with the parameters of a switched-off branch they give
// the same bits, and a quarter of the code.
template <class Softening, bool kShared>
void choose_branches(Material& m) {
  if (m.parameters.dilation) {
    m.lean = &run<Softening, kShared, true, true, false, false>;
    m.one = &run_one<Softening, kShared, true, true>;
  } else if (m.parameters.crushing) {
    m.lean = &run<Softening, kShared, true, false, false, false>;
    m.one = &run_one<Softening, kShared, true, false>;
  } else {
    m.lean = &run<Softening, kShared, false, false, false, false>;
    m.one = &run_one<Softening, kShared, false, false>;
  }
  m.full = &run<Softening, kShared, true, true, true, false>;
  m.columns = &run<Softening, kShared, true, true, true, true>;
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
  new (m.lanes) Lanes(material_lanes(m.parameters));
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
