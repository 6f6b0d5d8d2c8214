// The loop over points around the equations, compiled for every instruction set.
#include "cyclic_joint/kernel.h"

#include <new>
#include <type_traits>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cyclic_joint/kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "cyclic_joint/equations.h"
#include "shim/friction_column.h"
#include "shim/loop.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::cyclic_joint::HWY_NAMESPACE {
using namespace quoin::shim;

HWY_INLINE Lanes material_lanes(const Parameters& m) {
  const Properties& g = m.given;
  return Lanes(m, {splat(g.kn),      splat(g.ks), splat(g.ft),  splat(g.c0), splat(g.cr),  splat(g.mu0), splat(g.mur),
                   splat(g.tan_psi), splat(g.fc), splat(g.fcr), splat(g.G1), splat(g.G2),  splat(g.Gc),  splat(g.beta),
                   splat(g.sd),      splat(g.pd), splat(g.fy),  splat(g.wp), splat(g.chi), splat(g.Cs)});
}

// Returns the properties of the points from i on: columns where given, the material's values elsewhere. A yield stress
// by default is limited to the column of the compressive strength, and equal to it where the hardening length wp is 0.
inline Lanes column_lanes(const Parameters& m, const Columns& c, std::size_t i) {
  const Properties& g = m.given;
  const auto number = [&](int k, V value) {
    const double* column = c.in[kProperty + k];
    return column == nullptr ? value : load(column, i);
  };
  const auto material = [&](int k, double value) { return number(k, splat(value)); };
  const V mu0 = friction_column(c.in[kProperty + kColumnPhi0], i, splat(g.mu0));
  const V mur = friction_column(c.in[kProperty + kColumnPhir], i, residual_friction(g.mur, m.own_mur, mu0));
  const V tan_psi = friction_column(c.in[kProperty + kColumnPsi0], i, splat(g.tan_psi));
  const V fc = material(kColumnFc, g.fc), wp = material(kColumnWp, g.wp);
  const V yield = m.own_fy ? splat(g.fy) : hn::Min(splat(g.fy), fc);
  const V fy = number(kColumnFy, select(wp > zero(), yield, fc));
  return Lanes(m, {material(kColumnKn, g.kn),
                   material(kColumnKs, g.ks),
                   material(kColumnFt, g.ft),
                   material(kColumnC0, g.c0),
                   material(kColumnCr, g.cr),
                   mu0,
                   mur,
                   tan_psi,
                   fc,
                   material(kColumnFcr, g.fcr),
                   material(kColumnG1, g.G1),
                   material(kColumnG2, g.G2),
                   material(kColumnGc, g.Gc),
                   material(kColumnBeta, g.beta),
                   material(kColumnSd, g.sd),
                   material(kColumnPd, g.pd),
                   fy,
                   wp,
                   material(kColumnChi, g.chi),
                   material(kColumnCs, g.Cs)});
}

template <class Law>
HWY_INLINE V flags_of(const Law& law, const Result& r) {
  const Lanes& p = law.p;
  const State& s = r.state;
  const M moved = hn::Or(hn::Or(r.opens, r.slips), hn::Or(r.crushes, r.gives_way));
  const M crushed = s.l > p.wp, softens = p.wu > zero();
  const M crushed_out = hn::And(softens, law.beyond_peak(s.l) >= p.end);
  const M no_bond = hn::And(crushed_out, p.fcr == zero());
  V flags = flag_if(r.h > zero(), QUOIN_FLAG_OPEN);
  flags = flags + flag_if(r.slips, QUOIN_FLAG_SLIPPING);
  const M damaged = hn::Or(s.xi > zero(), hn::And(crushed, softens));
  const M complete = hn::Or(s.xi >= p.end, no_bond);
  flags = flags + flag_if(damaged, QUOIN_FLAG_TENSION_DAMAGED | QUOIN_FLAG_SHEAR_DAMAGED);
  flags = flags + flag_if(complete, QUOIN_FLAG_TENSION_COMPLETE | QUOIN_FLAG_SHEAR_COMPLETE);
  flags = flags + flag_if(s.l > zero(), QUOIN_FLAG_CRUSHED);
  flags = flags + flag_if(crushed_out, QUOIN_FLAG_CRUSHING_COMPLETE);
  flags = flags + flag_if(moved, QUOIN_FLAG_YIELDING);
  flags = flags + flag_if(r.reseats, QUOIN_FLAG_RESEATING);
  return flags + flag_if(r.gives_way, QUOIN_FLAG_GAVE_WAY);
}

// Returns the damage of a mode: 1 - B for tension and cohesion, which share the bond; the lost share of fc - fcr for
// crushing.
template <class Law>
HWY_INLINE V damage_of(const Law& law, const State& s, int mode) {
  const V one = splat(1.0);
  if (mode == QUOIN_DAMAGE_CRUSHING) return positive_part(one - law.f.factor(law.beyond_peak(s.l)));
  return positive_part(one - law.crushed(s.l).b * law.f.factor(s.xi));
}

// Reads and writes the columns of the points from i on through Access.
template <class Access>
struct At {
  const Columns& c;
  std::size_t i;

  HWY_INLINE V in(int k) const { return Access::load(c.in[k], i); }
  HWY_INLINE void out(int k, V value) const { Access::store(value, c.out[k], i); }

  HWY_INLINE Increment increment() const { return {in(kNormalJump), in(kSlipIncrement), in(kSlipIncrement + 1)}; }
  HWY_INLINE State state() const {
    const auto old = [&](int k) { return in(kStateOld + k); };
    return {old(kXi),
            old(kKappa),
            old(kQ),
            old(kL),
            old(kW),
            old(kGs),
            old(kGt),
            old(kRm),
            old(kVm),
            in(kTractionOld + 1),
            in(kTractionOld + 2)};
  }
  // Returns the states that the short path reads for a joint without residual opening, crushing and uplift.
  HWY_INLINE State untouched_state() const {
    State s{};
    s.xi = in(kStateOld + kXi), s.w = in(kStateOld + kW);
    s.q = in(kStateOld + kQ), s.l = in(kStateOld + kL), s.v_m = in(kStateOld + kVm);
    s.tau_s = in(kTractionOld + 1), s.tau_t = in(kTractionOld + 2);
    return s;
  }
  HWY_INLINE void put_traction(V sigma, V tau_s, V tau_t) const {
    out(kTractionNew, sigma);
    out(kTractionNew + 1, tau_s);
    out(kTractionNew + 2, tau_t);
  }
  HWY_INLINE void put(int k, V value) const { out(kStateNew + k, value); }
  HWY_INLINE void keep(int k) const { put(k, in(kStateOld + k)); }

  HWY_INLINE void put_history(M, const State& s) const {
    put(kXi, s.xi), put(kKappa, s.kappa), put(kQ, s.q), put(kL, s.l), put(kW, s.w);
    put(kGs, s.g_s), put(kGt, s.g_t), put(kRm, s.r_m), put(kVm, s.v_m);
  }
  // Nowhere, Everywhere: write the states that a step of closed, or of open, joints without crushing can change.
  HWY_INLINE void put_history(Nowhere, const State& s) const {
    put(kXi, s.xi), put(kQ, s.q), put(kGs, s.g_s), put(kGt, s.g_t);
    if (c.in_place) return;
    keep(kKappa), keep(kL), keep(kW), keep(kRm), keep(kVm);
  }
  HWY_INLINE void put_history(Everywhere, const State& s) const {
    put(kXi, s.xi), put(kKappa, s.kappa), put(kQ, s.q);
    if (c.in_place) return;
    keep(kL), keep(kW), keep(kGs), keep(kGt), keep(kRm), keep(kVm);
  }
  HWY_INLINE void keep_history() const {
    for (int k = 0; k < kSlip; ++k) keep(k);
    put_slip(zero());
  }
  HWY_INLINE void put_slip(V slip) const {
    if (c.out[kStateNew + kSlip]) out(kStateNew + kSlip, in(kStateOld + kSlip) + slip);
  }
};

// Steps 1 to 5 of a vector: calls law.evaluate and writes its outputs. Returns false, and writes nothing, if evaluate
// has no result.
template <bool kFull, class Access, class Law, class Open>
HWY_INLINE bool finish_step(const Law& law, const typename Law::Step& s, Open open, const At<Access>& at,
                            std::size_t count, Summary& summary) {
  Energies energies;
  Tangent tangent;
  Result r;
  if (!law.template evaluate<kFull, kFull>(s, open, r, &energies, &tangent)) return false;

  // One test for the whole vector: a value that is not finite, in or out, fails its point, whose outputs are the old
  // state.
  M sound = is_finite(gather_non_finite(r.state.xi, gather_non_finite(r.trial, gather_non_finite(r.sigma, r.used))));
  if constexpr (kFull) sound = hn::And(sound, law.p.admissible);
  if (!all(sound)) {
    r.sigma = select(sound, r.sigma, at.in(kTractionOld));
    r.state = either(sound, r.state, s.old);
    r.gamma = hn::IfThenElseZero(sound, r.gamma);
    r.opens = hn::And(sound, r.opens), r.slips = hn::And(sound, r.slips);
    r.crushes = hn::And(sound, r.crushes), r.gives_way = hn::And(sound, r.gives_way);
    summary.failed += hn::CountTrue(D(), hn::AndNot(sound, hn::FirstN(D(), count - at.i)));
  }

  if (!summary.yielding) {
    summary.yielding = !none(hn::Or(hn::Or(r.opens, r.slips), hn::Or(r.crushes, r.gives_way)));
  }
  at.put_slip(r.gamma);
  if constexpr (kFull) {
    put_extras(
        at.c, at.i, sound, energies, tangent, [&] { return flags_of(law, r); },
        [&](int mode) { return damage_of(law, r.state, mode); });
  }
  at.put_traction(r.sigma, r.state.tau_s, r.state.tau_t);
  at.put_history(open, r.state);
  return true;
}

template <bool kFull, class Access, class Law>
HWY_INLINE void step_any(const Law& law, const Columns& c, std::size_t i, std::size_t count, Summary& summary) {
  const At<Access> at{c, i};
  const State old = at.state();
  const auto s = law.template step_of<false>(at.increment(), old);
  finish_step<kFull>(law, s, s.h > zero(), at, count, summary);
}

// Whole step of a vector of joints without crushing that are all closed or all open. Returns false, and writes nothing,
// for other vectors and if evaluate has no result.
template <class Access, class Law>
HWY_INLINE bool step_plain(const Law& law, const Columns& c, std::size_t i, std::size_t count, Summary& summary) {
  const At<Access> at{c, i};
  const State old = at.state();
  if (!all(old.l == zero())) return false;
  const auto s = law.template step_of<true>(at.increment(), old);
  const M open = s.h > zero();
  if (none(open)) return finish_step<false>(law, s, Nowhere(), at, count, summary);
  return all(open) && finish_step<false>(law, s, Everywhere(), at, count, summary);
}

// Out of line, since it is rare.
template <class Access, class Law>
HWY_NOINLINE void step_other(const Law& law, const Columns& c, std::size_t i, std::size_t count, Summary& summary) {
  step_any<false, Access>(law, c, i, count, summary);
}

// Returns a copy of the columns that an elastic step reads, so that a loop over vectors need not keep c in memory.
template <std::size_t... k>
HWY_INLINE Columns inputs_of(const Columns& c, std::index_sequence<k...>) {
  Columns inputs;
  ((inputs.in[k] = c.in[k]), ...);
  return inputs;
}

template <class Access>
HWY_INLINE void put_elastic(const At<Access>& at, const Traction& traction) {
  if (!at.c.in_place) at.keep_history();
  at.put_traction(traction.sigma, traction.tau_s, traction.tau_t);
}

// Short path of vectors with residual opening, crushing or uplift. Out of line, since these are rare.
template <class Access, class Law>
HWY_NOINLINE bool elastic_and_touched(const Law& law, const Columns& c, std::size_t i, Traction& traction) {
  const At<Access> at{c, i};
  return law.template elastic<Access::kOnePoint, false>(at.increment(), at.state(), traction);
}

template <class Softening>
struct ShortPath {
  Equations<Softening, ShortLanes> untouched;
  const Equations<Softening>& any;
};
template <class Softening>
HWY_INLINE ShortPath<Softening> short_path(const Equations<Softening>& law) {
  return {{ShortLanes(law.p), law.f}, law};
}

template <class Access, class Softening>
HWY_INLINE bool step_elastic(const ShortPath<Softening>& law, const Columns& c, std::size_t i) {
  const At<Access> at{c, i};
  Traction traction;
  const State state = at.untouched_state();
  if (!law.untouched.template elastic<Access::kOnePoint, true>(at.increment(), state, traction)) {
    if (Access::kOnePoint || all(law.untouched.untouched(state))) return false;
    Traction touched;
    const Columns inputs = inputs_of(c, std::make_index_sequence<kStateOld + kSlip>());
    if (!elastic_and_touched<Access>(law.any, inputs, i, touched)) return false;
    traction = touched;
  }
  put_elastic(at, traction);
  return true;
}

// For a batch of one point: computes a step of a point with residual opening, crushing or uplift if it is elastic;
// returns false otherwise. In the whole step, so that the short path stays small.
template <class Access, class Law>
HWY_NOINLINE bool step_touched(const Law& law, const Columns& c, std::size_t i) {
  const At<Access> at{c, i};
  Traction traction;
  if (all(law.untouched(at.untouched_state())) || !elastic_and_touched<Access>(law, c, i, traction)) return false;
  put_elastic(at, traction);
  return true;
}

template <bool kFull, class Access, class Law>
HWY_INLINE void step_vector(const Law& law, const Columns& c, std::size_t i, std::size_t count, Summary& summary) {
  if constexpr (kFull) {
    step_any<kFull, Access>(law, c, i, count, summary);
  } else {
    if (Access::kOnePoint && step_touched<Access>(law, c, i)) return;
    if (!step_plain<Access>(law, c, i, count, summary)) step_other<Access>(law, c, i, count, summary);
  }
}

HWY_INLINE const Lanes& own_lanes(const Material& material) { return *reinterpret_cast<const Lanes*>(material.lanes); }

template <class Softening>
void run_lean(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  run_lean(Equations<Softening>{own_lanes(material), Softening(material.parameters)}, c, count, summary);
}

template <class Softening>
void run_full(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  const bool by_point = c.property_columns;
  Lanes point_lanes;
  const Equations<Softening> law{by_point ? point_lanes : own_lanes(material), Softening(material.parameters)};
  run_full(law, c, count, summary, [&](std::size_t i) {
    if (by_point) point_lanes = column_lanes(material.parameters, c, i);
  });
}

template <class Softening>
void run_one(const Material& material, const Columns& c, std::size_t count, Summary& summary) {
  run_one(Equations<Softening>{own_lanes(material), Softening(material.parameters)}, c, count, summary);
}

template <class Softening>
void choose_shape(Material& m) {
  m.lean = &run_lean<Softening>;
  m.one = &run_one<Softening>;
  m.full = &run_full<Softening>;
}

void choose_for_target(Material& m) {
  static_assert(sizeof(Lanes) <= sizeof m.lanes && alignof(Lanes) <= alignof(Material));
  static_assert(std::is_trivially_copyable_v<Lanes>);
  Lanes& lanes = *new (m.lanes) Lanes(material_lanes(m.parameters));
  lanes.admissible = hn::Eq(zero(), zero());  // make() has refused all other materials
  switch (m.parameters.shape) {
    case Shape::linear:
      return choose_shape<LinearSoftening>(m);
    case Shape::exponential:
      return choose_shape<ExponentialSoftening>(m);
    case Shape::table:
      return choose_shape<TableSoftening>(m);
  }
}

}  // namespace quoin::cyclic_joint::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin::cyclic_joint {

HWY_EXPORT(choose_for_target);

void choose_kernels(Material& material) { HWY_DYNAMIC_DISPATCH(choose_for_target)(material); }

}  // namespace quoin::cyclic_joint
#endif
