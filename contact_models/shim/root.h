// Root of a falling scalar function, one problem a lane.
#if defined(QUOIN_SHIM_ROOT_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_ROOT_H
#undef QUOIN_SHIM_ROOT_H
#else
#define QUOIN_SHIM_ROOT_H
#endif

#include "shim/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

// Newton's method kept inside a shrinking bracket, for the active lanes; x is the first guess, for other lanes the
// answer. function(x, value, slope) gives value > 0 at low and <= 0 at high. It need not fall all the way. Its last
// call is at the answer. A lane stops when |value| <= tolerance or its bracket has no number left inside; a lane's
// result does not depend on its neighbours. Every fourth step bisects, so that kinks (ends of branches, tables) cannot
// stall it. 216 steps are beyond the 4 x 53 halvings of any bracket and only bound the loop.
template <class Function>
HWY_INLINE V find_root(M active, V x, V low, V high, V tolerance, const Function& function) {
  M running = active;
  for (int step = 0;; ++step) {
    V value, slope;
    function(x, value, slope);
    running = hn::AndNot(hn::Le(hn::Abs(value), tolerance), running);
    if (none(running) || step == 216) break;
    const M before = hn::Gt(value, zero());
    low = select(before, x, low);
    high = select(before, high, x);
    const V middle = hn::MulAdd(splat(0.5), hn::Sub(high, low), low);
    const V newton = hn::Sub(x, hn::Div(value, slope));
    // Newton may land on the upper end, which is a root where the strength is used up. Not a number fails the test, and
    // so does a function that rises here, from where Newton leads away from the root.
    const M leads = hn::AndNot(hn::Gt(slope, zero()), hn::Gt(newton, low));
    const V next = step % 4 == 3 ? middle : select(leads, hn::Min(newton, high), middle);
    const M stuck = hn::Or(hn::Eq(next, x), hn::Ge(low, high));
    running = hn::AndNot(stuck, running);
    x = select(running, next, x);
  }
  return x;
}

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
