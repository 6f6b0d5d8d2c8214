// Internal forces of deformable blocks of any shape, zone by zone, eight zones at a time. Total Lagrangian with the
// Green strain E and a St. Venant-Kirchhoff law. With the displacement gradient H, S = lambda tr(E) 1 + 2 mu E and P =
// (1 + H) S. A corner with the shape gradient g gets the force -volume P g. Compiled for every instruction set of
// Highway and chosen at run time.
#pragma once

#include <span>

#include "model/block_zones.h"

namespace quoin::blocks {

struct ZoneStep {
  double beta;    // stiffness-proportional viscosity of zones, s; 0: none
  double dt;      // s
  bool energies;  // whether viscous forces are stored apart, and strain energy is computed
};

// Columns of a block, by gridpoint: four doubles each, the last one padding.
struct ZoneColumns {
  const double* displacement;  // m
  const double* velocity;      // m/s, at half steps; with beta > 0
  double* force;               // N; the whole force is added to it
  double* viscous;             // N; the viscous part is added to it; with beta > 0 and energies
};

// Adds the forces of zones to the columns; returns the strain energy, J, or 0 if energies are not requested.
double zone_forces(std::span<const ZoneLanes> zones, const ZoneStep& step, const ZoneColumns& columns);

// Sets product to K w of small strain, in the frame in which the zones were made. Rows have four doubles, the last one
// padding.
void stiffness_times(std::span<const ZoneLanes> zones, std::span<const double> w, double* product);

}  // namespace quoin::blocks
