// Vector of the lattice, for positions, sizes and rotations: x along the wall, y up, z through the thickness.
#pragma once

#include <array>
#include <cmath>

namespace quoin {

using Vec3 = std::array<double, 3>;

inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double norm_of(const Vec3& v) { return std::sqrt(dot(v, v)); }

}  // namespace quoin
