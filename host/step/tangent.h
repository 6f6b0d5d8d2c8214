// Small vibrations about the current state of a simulation: stiffness and mass of all free unknowns.
//
// The stiffness of a contact point is that of its law's response to a small motion. Open joints have none, damaged ones
// that of unloading, sliding ones that of sticking, as motion reverses. Zones are linearly elastic. Stresses of zones,
// and contact forces and loads on the arms of rigid blocks, add geometric stiffness (P-delta). Of pressures, which turn
// with their faces, the symmetric part of the stiffness counts.
#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "geometry/vector.h"
#include "sparse/sparse_cholesky.h"
#include "step/simulation.h"

namespace quoin {

struct Tangent {
  struct Unknown {
    int block = 0, gridpoint = -1;           // -1: a rigid block
    geometry::Vector translation{}, spin{};  // one of them a unit vector; spin about the centre
    geometry::Vector centre{};               // m
  };
  Eigen::SparseMatrix<double> stiffness;  // lower triangle, N/m, N m
  // Damping matrix of impact and viscous damping, lower triangle, N s/m, N m s: of closed contacts, zones and masses.
  // Empty: the stage has another kind of damping, or none.
  Eigen::SparseMatrix<double> viscosity;
  std::vector<double> mass;  // diagonal of the mass matrix, kg, kg m2; without mass scaling
  std::vector<Unknown> unknown;
  UnknownGroups groups;
  long points = 0, open = 0;  // contact points, and those of them that are open
  double symmetry_factor = 1.0;
};

// Under the supports of the current stage; in one process.
Tangent tangent_of(const Simulation::Impl& s);

}  // namespace quoin
