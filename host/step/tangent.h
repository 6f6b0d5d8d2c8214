// Small vibrations about the present state of a simulation: stiffness and mass of all that can move.
//
// Contact points have the stiffness with which their laws answer a small motion of now. Joints that are open carry
// nothing, damaged ones unload as their law has it, sliding ones stick when the motion turns back. Zones are linearly
// elastic. Stresses of zones and forces on the arms of rigid blocks add to stiffness as they turn (P-delta).
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
  // The same of the viscosity of impact and viscous damping, N s/m, N m s. It is that of contacts that are closed, of
  // zones and of masses. Empty: the damping of the stage is of another kind, or none.
  Eigen::SparseMatrix<double> viscosity;
  std::vector<double> mass;  // diagonal, kg, kg m2; without scaling
  std::vector<Unknown> unknown;
  UnknownGroups groups;
  long points = 0, open = 0;  // contact points, and of them those that carry nothing
  double symmetry_factor = 1.0;
};

// With what the current stage holds, in one process.
Tangent tangent_of(const Simulation::Impl& s);

}  // namespace quoin
