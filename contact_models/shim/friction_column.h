// Converts friction and dilation angles that are given point by point, in degrees, to coefficients.
#if defined(QUOIN_SHIM_FRICTION_COLUMN_H) == defined(HWY_TARGET_TOGGLE)
#ifdef QUOIN_SHIM_FRICTION_COLUMN_H
#undef QUOIN_SHIM_FRICTION_COLUMN_H
#else
#define QUOIN_SHIM_FRICTION_COLUMN_H
#endif

#include <cmath>

#include "shim/lanes.h"

HWY_BEFORE_NAMESPACE();
namespace quoin::shim::HWY_NAMESPACE {

// Returns tan of column[i ...]: -1, which the law refuses, for an angle outside [0, 90). Without a column: value.
inline V friction_column(const double* column, std::size_t i, V value) {
  if (column == nullptr) return value;
  HWY_ALIGN double lanes[kMaxLanes];
  for (std::size_t lane = 0; lane < hn::Lanes(D()); ++lane) {
    const double degrees = column[i + lane];
    lanes[lane] = degrees >= 0.0 && degrees < 90.0 ? std::tan(degrees * (M_PI / 180.0)) : -1.0;
  }
  return hn::Load(D(), lanes);
}

// Residual friction of points without a column of it: the material's value, which a friction column limits where it is
// its default. A value that was given stays, and the law refuses points whose friction is less.
inline V residual_friction(double value, bool is_given, V friction) {
  return is_given ? splat(value) : hn::Min(splat(value), friction);
}

}  // namespace quoin::shim::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
