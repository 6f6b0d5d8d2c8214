// Two axes s, t of the contact plane, which rotate with the contact. 3DEC does not give a model the normal of its
// contact. Both the shear force, which 3DEC rotates with the contact, and the increments of shear displacement lie in
// the plane. The axes are computed from them; an axis that is not determined yet is zero.
#pragma once

#include <array>
#include <cmath>

#include "3dec/interface_types.h"

namespace quoin::threedec {

inline DVect3 cross(const DVect3& a, const DVect3& b) {
  return {a.y() * b.z() - a.z() * b.y(), a.z() * b.x() - a.x() * b.z(), a.x() * b.y() - a.y() * b.x()};
}
inline bool same(const DVect3& a, const DVect3& b) { return a.x() == b.x() && a.y() == b.y() && a.z() == b.z(); }

class ShearAxes {
 public:
  DVect3 vector(double s, double t) const {
    return {s_[0] * s + t_[0] * t, s_[1] * s + t_[1] * t, s_[2] * s + t_[2] * t};
  }

  // Rotates the axes with the contact, by the smallest rotation from the shear force `before` to `now`. A force of
  // another direction, for example one that the user has set, only determines the plane.
  void follow(const DVect3& before, const DVect3& now) {
    const double product = std::sqrt((before | before) * (now | now));
    if (known_ > 0 && (before | now) > 0.5 * product) turn(before / before.mag(), now / now.mag());
    components(now, now);
  }

  // Returns the components along s and t of a vector v in the contact plane. If v is outside the plane of the axes, the
  // contact has rotated about the shear force `held`; the axes are rotated, too.
  std::array<double, 2> components(const DVect3& v, const DVect3& held) {
    const std::array<double, 2> c = along(v);
    const double square = v | v;
    // Up to this share of the square, the part out of the plane does not change the length in double precision.
    if (known_ == 2 && square - (c[0] * c[0] + c[1] * c[1]) <= 1e-14 * square) return c;
    return shown(v, c, held);
  }

 private:
  std::array<double, 2> along(const DVect3& v) const {
    return {v.x() * s_[0] + v.y() * s_[1] + v.z() * s_[2], v.x() * t_[0] + v.y() * t_[1] + v.z() * t_[2]};
  }
  DVect3 s() const { return vector(1.0, 0.0); }
  DVect3 t() const { return vector(0.0, 1.0); }
  static void put(const DVect3& from, double* to) { to[0] = from.x(), to[1] = from.y(), to[2] = from.z(); }

  // Returns `components` after choosing or rotating axes so that v lies in their plane.
  std::array<double, 2> shown(const DVect3& v, const std::array<double, 2>& c, const DVect3& held) {
    const DVect3 rest = v - vector(c[0], c[1]);
    constexpr double rounding = 1e-28;  // square of the relative rounding error across an axis
    if (known_ == 2) {
      lean(v, held);
    } else if ((rest | rest) > rounding * (v | v)) {
      put(rest / rest.mag(), known_ == 0 ? s_ : t_);
      ++known_;
    }
    return along(v);
  }

  void lean(const DVect3& v, const DVect3& held) {
    const DVect3 normal = cross(s(), t());
    DVect3 leaned = cross(held, v);
    // Without a force, or with one along v: the new normal is the part of the old one perpendicular to v.
    if ((leaned | leaned) <= 1e-16 * (held | held) * (v | v)) leaned = normal * (v | v) - v * (normal | v);
    const double size = (leaned | normal) < 0.0 ? -leaned.mag() : leaned.mag();
    if (size != 0.0) turn(normal, leaned / size);
  }

  // Rotates the axes by the smallest rotation from the unit vector a to the unit vector b, which is less than 180 deg.
  void turn(const DVect3& a, const DVect3& b) {
    const DVect3 sum = a + b;
    const double half = 1.0 / (1.0 + (a | b));
    const auto turned = [&](const DVect3& v) { return v + b * (2.0 * (v | a)) - sum * ((v | sum) * half); };
    const DVect3 first = turned(s()) / turned(s()).mag();
    put(first, s_);
    if (known_ < 2) return;
    const DVect3 second = turned(t()) - first * (first | turned(t()));  // orthogonal in spite of rounding
    put(second / second.mag(), t_);
  }

  // Not DVect3, whose default has no defined value: a joint model saves its axes as bytes.
  double s_[3] = {0.0, 0.0, 0.0}, t_[3] = {0.0, 0.0, 0.0};
  unsigned long long known_ = 0;  // number of axes that are determined
};

}  // namespace quoin::threedec
