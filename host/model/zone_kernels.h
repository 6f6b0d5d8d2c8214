// Internal forces of deformable blocks of any shape, zone by zone, eight zones a vector: total Lagrangian with the
// Green strain E and a St. Venant-Kirchhoff law. With the displacement gradient H, S = lambda tr(E) 1 + 2 mu E and P =
// (1 + H) S. A corner with the shape gradient g gets -volume P g. Compiled for every instruction set of Highway and
// chosen at run time.
#pragma once

#include <span>

#include "model/block_zones.h"

namespace quoin::blocks {

// What a step requests.
struct ZoneStep {
  double beta;    // stiffness-proportional viscosity of zones, s; 0: none
  double dt;      // s
  bool energies;  // viscous forces by themselves, and the strain energy, are requested
};

// Columns of a block, by gridpoint: four doubles each, the last of no meaning.
struct ZoneColumns {
  const double* displacement;  // m
  const double* velocity;      // m/s, at half steps; with beta > 0
  double* force;               // N, is added to: all of it
  double* viscous;             // N, is added to: the viscous part; with beta > 0 and energies
};

// Strain energy, J, where energies are requested; else 0.
double zone_forces(std::span<const ZoneLanes> zones, const ZoneStep& step, const ZoneColumns& columns);

// K w of small strain, in the frame in which the zones were made. Rows have four doubles, the last of no meaning;
// product is set.
void stiffness_times(std::span<const ZoneLanes> zones, std::span<const double> w, double* product);

}  // namespace quoin::blocks
