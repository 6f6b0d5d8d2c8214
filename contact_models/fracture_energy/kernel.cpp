// The loop over points around the equations, compiled for every instruction set.
#include "fracture_energy/kernel.h"

#include "quoin/quoin.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fracture_energy/kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "fracture_energy/equations.h"
#include "shim/friction_column.h"

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

template <class Softening, bool kShared, bool kCrushing, bool kDilation, bool kFull, bool kColumns>
void run(const Parameters& material, const Columns& c, std::size_t count, Summary& summary) {
  const D d;
  const Softening softening(material);
  Lanes p = material_lanes(material);
  const Equations<Softening, kShared, kCrushing, kDilation> law{p, softening};
  const auto state_in = [&](int k, std::size_t i) { return load(c.in[kStateOld + k], i); };
  const auto state_out = [&](int k) { return c.out[kStateNew + k]; };
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    if constexpr (kColumns) p = column_lanes(material, c, i);
    const Increment in{load(c.in[kNormalJump], i), load(c.in[kSlipIncrement], i), load(c.in[kSlipIncrement + 1], i)};
    State old;
    old.tau_s = load(c.in[kTractionOld + 1], i);
    old.tau_t = load(c.in[kTractionOld + 2], i);
    old.xi_t = state_in(kXiT, i);
    old.xi_s = kShared ? old.xi_t : state_in(kXiS, i);
    old.w = kCrushing || kFull ? state_in(kW, i) : zero();
    old.v = kDilation || kFull ? state_in(kV, i) : zero();

    const bool in_place = state_out(kXiT) == c.in[kStateOld + kXiT];
    const auto store_traction = [&](const Result& result) {
      store(result.sigma, c.out[kTractionNew], i);
      store(result.state.tau_s, c.out[kTractionNew + 1], i);
      store(result.state.tau_t, c.out[kTractionNew + 2], i);
    };
    const auto store_state = [&](const Result& result) {
      store(result.state.xi_t, state_out(kXiT), i);
      store(result.state.xi_s, state_out(kXiS), i);
      store(kCrushing || kFull ? result.state.w : state_in(kW, i), state_out(kW), i);
      store(kDilation || kFull ? result.state.v : state_in(kV, i), state_out(kV), i);
    };

    Energies energies;
    Tangent tangent;
    Result r;
    if constexpr (!kFull) {
      if (law.elastic(in, old, r)) {
        store_traction(r);
        if (!in_place) {
          store_state(r);
          if (state_out(kSlip)) store(state_in(kSlip, i), state_out(kSlip), i);
        }
        continue;
      }
    }
    if constexpr (kFull) {
      r = law.template evaluate<true, true>(in, old, &energies, &tangent);
    } else {
      r = law.template evaluate<false, false>(in, old, nullptr, nullptr);
    }

    // One test for the whole vector: not a number anywhere in or out fails the point, outputs equal the old state.
    V collected = gather_non_finite(r.sigma, gather_non_finite(r.state.tau_s, zero()));
    collected = gather_non_finite(r.state.tau_t, gather_non_finite(r.state.xi_t, collected));
    collected = gather_non_finite(r.state.xi_s, gather_non_finite(in.d_n, collected));
    // A minimum or maximum inside the equations may lose an old value that is not a number.
    collected = gather_non_finite(old.xi_t, gather_non_finite(old.xi_s, collected));
    collected = gather_non_finite(old.w, gather_non_finite(old.v, collected));
    if constexpr (kCrushing || kFull) collected = gather_non_finite(r.state.w, collected);
    if constexpr (kDilation || kFull) collected = gather_non_finite(r.state.v, collected);
    M sound = is_finite(collected);
    if constexpr (kColumns) sound = hn::And(sound, p.admissible);
    if (!all(sound)) {
      r.sigma = select(sound, r.sigma, load(c.in[kTractionOld], i));
      r.state.tau_s = select(sound, r.state.tau_s, old.tau_s);
      r.state.tau_t = select(sound, r.state.tau_t, old.tau_t);
      r.state.xi_t = select(sound, r.state.xi_t, old.xi_t);
      r.state.xi_s = select(sound, r.state.xi_s, state_in(kXiS, i));
      r.state.w = select(sound, r.state.w, old.w);
      r.state.v = select(sound, r.state.v, old.v);
      r.slip = hn::IfThenElseZero(sound, r.slip);
      r.slips = hn::And(sound, r.slips);
      summary.failed += hn::CountTrue(d, hn::AndNot(sound, hn::FirstN(d, count - i)));
    }

    store_traction(r);
    M moved = hn::And(sound, hn::Or(r.opens, r.slips));
    if constexpr (kCrushing) moved = hn::Or(moved, hn::And(sound, r.crushes));
    const bool yields = !none(hn::And(moved, hn::FirstN(d, count - i)));
    summary.yielding |= yields;
    if (yields || !in_place) store_state(r);
    if (state_out(kSlip)) store(hn::Add(state_in(kSlip, i), r.slip), state_out(kSlip), i);

    if constexpr (kFull) {
      const auto put = [&](int k, V value) {
        if (c.out[k]) store(hn::IfThenElseZero(sound, value), c.out[k], i);
      };
      put(kEnergyStored, energies.stored);
      put(kDissipated + QUOIN_DISSIPATED_TENSION, energies.tension);
      put(kDissipated + QUOIN_DISSIPATED_COHESION, energies.cohesion);
      put(kDissipated + QUOIN_DISSIPATED_FRICTION, energies.friction);
      put(kDissipated + QUOIN_DISSIPATED_CRUSHING, energies.crushing);
      for (int k = 0; k < 9; ++k) put(kTangent + k, tangent.entry[k]);
      if (c.out[kFlags]) put(kFlags, flags_of(p, r, old));
      if (c.out[kStatus]) store(hn::IfThenZeroElse(sound, splat(QUOIN_POINT_FAILED)), c.out[kStatus], i);
    }
  }
}

// Extra outputs and columns always take the general branches: with the parameters of a switched-off branch they give
// the same bits, and a quarter of the code.
template <class Softening, bool kShared>
Kernels of_shape(const Parameters& m) {
  Kernels kernels{&run<Softening, kShared, true, true, false, false>, &run<Softening, kShared, true, true, true, false>,
                  &run<Softening, kShared, true, true, true, true>};
  if (!m.dilation) kernels.lean = &run<Softening, kShared, true, false, false, false>;
  if (!m.dilation && !m.crushing) kernels.lean = &run<Softening, kShared, false, false, false, false>;
  return kernels;
}

template <bool kShared>
Kernels of_coupling(const Parameters& m) {
  switch (m.shape) {
    case Shape::exponential:
      return of_shape<ExponentialSoftening, kShared>(m);
    case Shape::table:
      return of_shape<TableSoftening, kShared>(m);
    case Shape::linear:
      break;
  }
  return of_shape<LinearSoftening, kShared>(m);
}

void select_for_target(const Parameters& m, Kernels& kernels) {
  kernels = m.shared ? of_coupling<true>(m) : of_coupling<false>(m);
}

}  // namespace quoin::fracture_energy::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace quoin::fracture_energy {

HWY_EXPORT(select_for_target);

Kernels select_kernels(const Parameters& material) {
  Kernels kernels{};
  HWY_DYNAMIC_DISPATCH(select_for_target)(material, kernels);
  return kernels;
}

}  // namespace quoin::fracture_energy
#endif
