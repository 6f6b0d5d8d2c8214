// Parameters of the cyclic joint law, derived once when a material is made. Symbols as in LAW.md.
#pragma once

#include "shim/softening_shape.h"

namespace quoin::cyclic_joint {

using shim::Shape;

// The user's properties. Friction and dilation are coefficients: tangents, not angles, are interpolated.
struct Properties {
  double kn, ks;      // stiffness, Pa/m
  double ft, c0, cr;  // strengths, Pa
  double mu0, mur;    // friction coefficients
  double tan_psi;     // dilation coefficient
  double fc, fcr;     // compressive strength and residual, Pa
  double G1, G2, Gc;  // fracture energies, J/m2
  double beta;        // share of the softening opening that remains when the joint closes
  double sd, pd;      // slip (m; 0: su) and pressure (Pa) at which dilation ends
  double fy, wp;      // stress at which crushing starts, Pa; crushing l at fc, m
  double chi;         // factor of the compliance that crushing adds, chi l/fc
  double Cs;          // factor of shear in the cap p^2 + Cs tau^2 = F^2
};

struct Parameters : shim::SofteningShape {
  Properties given;
  bool own_mur = false, own_fy = false;  // friction_angle_residual and compressive_yield were given
};

}  // namespace quoin::cyclic_joint
