// What every contact point in large motion has, whatever it lies between, vector by vector. It is the traction of
// stiffness-proportional damping, and the energies of its law. Compiled for every instruction set of Highway and chosen
// at run time; sums go by eight lanes on all of them.
#pragma once

#include <cstddef>

#include "law/law_library.h"
#include "model/maxwell.h"

namespace quoin::blocks {

// Columns of some points, from the first of them on.
struct DampingColumns {
  const double *traction[3], *old_traction[3];  // Pa
  const double *normal_jump, *slip[2], *area;   // m, m, m2
  double *viscous[3], *old_jump;                // Pa, m; not a number: born since
};

// The rate of the traction itself, so that slip and open joints are not damped. It may slow a closed contact but never
// pull on it. rate: beta / dt. Its work, J.
double damp_points(const DampingColumns& columns, std::size_t count, double rate);

// Maxwell elements beside the springs of these points (model/maxwell.h).
struct MaxwellColumns {
  double* traction[3 * kMaxwellElements];    // Pa; null: none
  double keep[kMaxwellElements];             // share of the element's traction that a step keeps
  double gain[kMaxwellElements];             // share of the change of the law's traction that it takes
  double normal_stiffness, shear_stiffness;  // stiffness of undamaged joints, Pa/m
};

// The same of closed contacts alone, where blocks land, at rates of their own normal to the joint and along it. Maxwell
// elements act on all that touch, and lose their force where a joint opens, slides or softens.
double damp_impacts(const DampingColumns& columns, const MaxwellColumns& maxwell, std::size_t count, double normal,
                    double along);

// Sums of area times density.
struct EnergyColumns {
  const double *area, *stored, *dissipated[QUOIN_DISSIPATED_COUNT];  // m2, J/m2
};
struct PointEnergies {
  double stored, dissipated[QUOIN_DISSIPATED_COUNT];  // J
};
PointEnergies energies_of_points(const EnergyColumns& columns, std::size_t count);

}  // namespace quoin::blocks
