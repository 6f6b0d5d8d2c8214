// Masks that are constant at compile time. A template over Nowhere, Everywhere and M compiles to three versions, in
// which no lane, every lane or any lane takes a branch. The first two omit the code of the branch that is not taken. A
// lane's numbers are the same in all three.
#if defined(QUOIN_SHIM_KNOWN_MASK_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_KNOWN_MASK_H
#undef QUOIN_SHIM_KNOWN_MASK_H
#else
#define QUOIN_SHIM_KNOWN_MASK_H
#endif

#include "shim/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

struct Nowhere {
  HWY_INLINE operator M() const { return hn::MaskFromVec(zero()); }
};
struct Everywhere {
  HWY_INLINE operator M() const { return hn::FirstN(D(), hn::Lanes(D())); }
};

HWY_INLINE bool none(Nowhere) { return true; }
HWY_INLINE bool none(Everywhere) { return false; }

HWY_INLINE Everywhere opposite(Nowhere) { return {}; }
HWY_INLINE Nowhere opposite(Everywhere) { return {}; }
HWY_INLINE M opposite(M mask) { return hn::Not(mask); }

HWY_INLINE Nowhere both(Nowhere, M) { return {}; }
HWY_INLINE M both(Everywhere, M mask) { return mask; }
HWY_INLINE M both(M a, M b) { return hn::And(a, b); }

HWY_INLINE V select(Nowhere, V, V no) { return no; }
HWY_INLINE V select(Everywhere, V yes, V) { return yes; }

// only: x where the mask is set, 0 elsewhere. unless: 0 where the mask is set, x elsewhere.
HWY_INLINE V only(Nowhere, V) { return zero(); }
HWY_INLINE V only(Everywhere, V x) { return x; }
HWY_INLINE V only(M mask, V x) { return hn::IfThenElseZero(mask, x); }
HWY_INLINE V unless(Nowhere, V x) { return x; }
HWY_INLINE V unless(Everywhere, V) { return zero(); }
HWY_INLINE V unless(M mask, V x) { return hn::IfThenZeroElse(mask, x); }

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
