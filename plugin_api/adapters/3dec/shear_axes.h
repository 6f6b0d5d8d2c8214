// Two axes of the contact plane in which a step of the shear force happens. 3DEC does not tell a model the normal, and
// a law does not care where s points as long as force and slip are seen from the same axes: s follows the old force.
#pragma once

#include <cmath>

#include "3dec/interface_types.h"

namespace quoin::threedec {

class ShearAxes {
 public:
  // force: on block A's side as 3DEC has it, against the displacement.
  ShearAxes(const DVect3& force, double area, const DVect3& increment) {
    const double size = force.mag();
    if (size > 0.0) {
      s_ = force / -size;
      traction_ = size / area;
    } else if (const double length = increment.mag(); length > 0.0) {
      s_ = increment / length;
    }
    slip_[0] = increment | s_;
    // What rounding leaves of a parallel increment points anywhere; its length alone is to be trusted.
    const DVect3 across = increment - s_ * slip_[0];
    if (const double square = across | across; square > 0.0) {
      slip_[1] = std::sqrt(square);
      t_ = across / slip_[1];
    }
  }

  double traction() const { return traction_; }  // along s; none along t
  const double* slip() const { return slip_; }
  DVect3 vector(double s, double t) const { return s_ * s + t_ * t; }

 private:
  // DVect3's own default is no number: an axis that nothing shows is zero.
  DVect3 s_{0.0, 0.0, 0.0}, t_{0.0, 0.0, 0.0};
  double traction_ = 0.0;
  double slip_[2] = {0.0, 0.0};
};

}  // namespace quoin::threedec
