// Vector of the lattice, for positions, sizes and rotations: x along the wall, y up, z through the thickness.
#pragma once

#include <array>
#include <cmath>

namespace quoin {

using Vec3 = std::array<double, 3>;

inline Vec3& operator+=(Vec3& a, const Vec3& b) { return a[0] += b[0], a[1] += b[1], a[2] += b[2], a; }
inline Vec3& operator-=(Vec3& a, const Vec3& b) { return a[0] -= b[0], a[1] -= b[1], a[2] -= b[2], a; }
inline Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
inline Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
inline Vec3 operator*(double f, const Vec3& a) { return {f * a[0], f * a[1], f * a[2]}; }
inline Vec3 operator/(const Vec3& a, double f) { return {a[0] / f, a[1] / f, a[2] / f}; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double norm_of(const Vec3& v) { return std::sqrt(dot(v, v)); }

}  // namespace quoin
