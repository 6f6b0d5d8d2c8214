// Parameters of the brittle Coulomb-slip law. Symbols as in fracture_energy/LAW.md, "The other laws that ship".
#pragma once

namespace quoin::coulomb_slip {

struct Parameters {
  double kn, ks;    // stiffness, Pa/m
  double ft, ftr;   // tensile strength before and after failure, Pa
  double c0, cr;    // cohesion before and after failure, Pa; the residual acts only while closed
  double mu0, mur;  // friction coefficients before and after failure
  bool own_mur;     // friction_angle_residual was given
};

}  // namespace quoin::coulomb_slip
