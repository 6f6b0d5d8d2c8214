// Parameters of the fracture-energy law, derived once when a material is made. Symbols as in LAW.md.
#pragma once

#include "shim/softening_shape.h"

namespace quoin::fracture_energy {

using shim::Shape;

// The user's properties. Friction and dilation are coefficients: tangents, not angles, are interpolated.
struct Properties {
  double kn, ks;      // stiffness, Pa/m
  double ft, c0, cr;  // strengths, Pa
  double mu0, mur;    // friction coefficients
  double tan_psi;     // dilation coefficient
  double fc, fcr;     // compressive strength and residual, Pa
  double G1, G2, Gc;  // fracture energies, J/m2
};

struct Parameters : shim::SofteningShape {
  Properties given;
  bool own_mur = false;   // friction_angle_residual was given
  bool shared = true;     // one internal variable for tension and shear
  bool crushing = false;  // fc is finite
  bool dilation = false;
};

}  // namespace quoin::fracture_energy
