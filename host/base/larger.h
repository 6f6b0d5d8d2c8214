// Maxima that keep NaN, so that what is not finite is found.
#pragma once

namespace quoin {

// The larger of two numbers; NaN once one of them is.
constexpr double larger(double a, double b) { return b <= a || a != a ? a : b; }

}  // namespace quoin
