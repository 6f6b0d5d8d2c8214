// Parameters of the bond-slip law. Symbols as in LAW.md.
#pragma once

namespace quoin::bond_slip {

struct Parameters {
  double kn, ks;      // stiffness, Pa/m
  double tau_m, f_p;  // bond and peel strength, Pa; infinite: the bond loses no strength
  double G_f;         // fracture energy of pure slip, J/m2
};

}  // namespace quoin::bond_slip
