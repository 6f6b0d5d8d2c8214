// Quantities that all contact points have, whatever blocks they lie between: the traction of damping, and energies.
// Compiled for every instruction set of Highway and chosen at run time. With any of these, sums have eight lanes.
#pragma once

#include <cstddef>

#include "law/bound_call.h"
#include "model/contact_points.h"
#include "model/maxwell.h"

namespace quoin::blocks {

// Columns of some consecutive points, beginning at the first. Those that a kernel does not take may be null.
struct PointColumns {
  const double *arm[3], *offset, *area;         // m, m, m2
  const double *traction[3], *old_traction[3];  // Pa
  double *viscous[3], *old_jump;                // Pa, null: none; opening of the last step, m, NaN: a new point
  double *slid[2], *normal_jump, *slip[2];      // position along s, t; opening; slip increment, m
};
PointColumns columns_of(Family& f, std::size_t first = 0);

// A number of each point: `all`, times its column where that is given.
struct OfPoints {
  double all;
  const double* column = nullptr;
};

// Computes tractions of stiffness-proportional damping from the rate of the law's traction: slip and open joints are
// not damped. They may reduce the compression of a closed contact to zero, but cause no tension. rate: beta / dt.
// Returns the work of damping, J.
double damp_points(const PointColumns& columns, std::size_t count, double rate);

// Maxwell elements in parallel with the springs of these points (model/maxwell.h).
struct MaxwellColumns {
  double* traction[3 * kMaxwellElements];  // Pa; null: none
  double keep[kMaxwellElements];           // share of an element's traction that remains after a step
  double gain[kMaxwellElements];           // share of the change of the law's traction that an element takes
  OfPoints normal, shear;                  // stiffness of undamaged joints, Pa/m
};

// The same for closed contacts alone, where blocks impact: separate rates normal to the joint and along it. Maxwell
// elements act on all points in contact. They lose their traction where a joint opens, slides or softens.
double damp_impacts(const PointColumns& columns, const MaxwellColumns& maxwell, std::size_t count,
                    const OfPoints& normal, const OfPoints& along);

// Sums the energies of the call's points from their densities, into the results of the call. area: of its points, m2.
// Energies that the call does not have are 0.
void sum_energies(const double* area, BoundCall& call);

}  // namespace quoin::blocks
