#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "elastic/kernel.cpp"
#include "elastic/equations.h"
#include "hwy/foreach_target.h"  // IWYU pragma: keep

#if HWY_ONCE
#include "elastic/kernel.h"

namespace quoin::elastic {

HWY_EXPORT(evaluate);

void evaluate(const Parameters& material, const shim::Columns& columns, std::size_t count, shim::Summary& summary) {
  HWY_DYNAMIC_DISPATCH(evaluate)(material, columns, count, summary);
}

}  // namespace quoin::elastic
#endif
