// Energies, tangent, damage, flags and status of the points of one vector, written where a host requests them.
#if defined(QUOIN_SHIM_EXTRAS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_EXTRAS_H
#undef QUOIN_SHIM_EXTRAS_H
#else
#define QUOIN_SHIM_EXTRAS_H
#endif

#include "quoin/quoin.h"
#include "shim/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

struct Energies {
  // J/m2. stored: recoverable at the end of the step; the others: dissipated during the step.
  V stored, tension, cohesion, friction, crushing;
};

struct Tangent {
  V entry[9];  // d(sigma, tau_s, tau_t)/d(d_n, d_s, d_t), row by row, Pa/m
};

// Writes the requested outputs of the points from i on; calls flags() and damage(mode) only for these. A point that is
// not sound gets zeros and the status QUOIN_POINT_FAILED.
template <class Flags, class Damage>
HWY_INLINE void put_extras(const Columns& c, std::size_t i, M sound, const Energies& energies, const Tangent& tangent,
                           const Flags& flags, const Damage& damage) {
  const auto put = [&](int k, V value) {
    if (c.out[k]) store(hn::IfThenElseZero(sound, value), c.out[k], i);
  };
  put(kEnergyStored, energies.stored);
  put(kDissipated + QUOIN_DISSIPATED_TENSION, energies.tension);
  put(kDissipated + QUOIN_DISSIPATED_COHESION, energies.cohesion);
  put(kDissipated + QUOIN_DISSIPATED_FRICTION, energies.friction);
  put(kDissipated + QUOIN_DISSIPATED_CRUSHING, energies.crushing);
  // + 0 makes every zero positive: its sign would show whether another point of the vector slips.
  for (int k = 0; k < 9; ++k) put(kTangent + k, hn::Add(tangent.entry[k], zero()));
  for (int k = 0; k < QUOIN_DAMAGE_COUNT; ++k) {
    if (c.out[kDamage + k]) put(kDamage + k, damage(k));
  }
  if (c.out[kFlags]) put(kFlags, flags());
  if (c.out[kStatus]) store(hn::IfThenZeroElse(sound, splat(QUOIN_POINT_FAILED)), c.out[kStatus], i);
}

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
