// Root of a falling scalar function, one problem for each lane.
#if defined(QUOIN_SHIM_ROOT_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_ROOT_H
#undef QUOIN_SHIM_ROOT_H
#else
#define QUOIN_SHIM_ROOT_H
#endif

#include "shim/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

// Returns the root in the active lanes by Newton's method inside a shrinking bracket; other lanes return x. x: first
// guess. function(x, value, slope): value > 0 at low and <= 0 at high; it need not fall everywhere between. The last
// call of function is at the root. A lane stops when |value| <= tolerance or its bracket contains no further number.
// A lane's result does not depend on its neighbours. Every fourth step bisects, so that kinks (ends of branches,
// tables) do not stall the search. 216 steps exceed the 4 x 53 halvings of any bracket and only bound the loop.
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
    // Newton's step may end at high, which is a root where the strength is used up. NaN fails the test. So does a
    // rising slope, from which Newton's step goes away from the root.
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
