#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/kernel.cpp"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

// After foreach_target.h, which includes this file once for every instruction set.
#include "elastic/equations.h"

#if HWY_ONCE
#include "elastic/kernel.h"

namespace quoin::elastic {

HWY_EXPORT(evaluate);
HWY_EXPORT(evaluate_one);

void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate)(material, columns, count, summary);
}
void evaluate_one(const Parameters& material, const shim::Columns& columns, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate_one)(material, columns, summary);
}

}  // namespace quoin::elastic
#endif
