// Rigid blocks in large motion.
#pragma once

#include <cstdint>

#include "geometry/vector.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Quaternion;
using geometry::Vector;

// Rigid block. Body frame: principal axes through the centre of mass. Members are in the order in which kernels read
// them.
struct Body {
  Vector x;                  // centre of mass, m
  Quaternion q;              // rotation from the body frame to space
  Vector v;                  // m/s, at half steps
  Vector momentum;           // angular, about the centre of mass, in space, at half steps
  Vector omega;              // rad/s, in space, at half steps
  Vector force, torque;      // resultants of the step
  double weight_mass = 0.0;  // mass for weight, kg
  double mass = 0.0;         // mass for inertia, kg (mass scaling included)
  Vector inertia;            // principal, kg m2
  Vector held_v, held_omega;
  Matrix r, transposed_r;  // rotation matrix of q
  uint8_t held = 0;        // bits 0..2: velocity prescribed along x, y, z; 3..5: rotation about them
  uint8_t support = 0;     // bits of `held` that a plane of symmetry holds for good
  uint8_t unused[6] = {};  // see base/archive.h

  void turn_to(const Quaternion& orientation) {
    q = orientation;
    r = matrix(q);
    transposed_r = transposed(r);
  }
};

}  // namespace quoin::blocks
