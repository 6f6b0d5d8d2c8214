// Deformable blocks in large motion, eight side by side: gridpoints moved on, and the forces inside of blocks. These
// come from a stiffness in their own frame, which congruent blocks share. Compiled for every instruction set of Highway
// and chosen at run time. What a lane holds does not depend on the others: the bits stay in any company.
//
// Blocks in their frames. X: places of the undeformed shape about its mass centre, m: masses, x: places now;
//   b = m S^-1 X,  S = sum m X X^T,   F = sum x b^T = R U (polar),   u = R^T (x - c) - X.
// The strain energy 1/2 u . K u has the forces
//   f = -R (g - q x b),  g = K u,  q = (tr(U) 1 - U)^-1 sum (X + u) x g;
// the second part is what R turns by when a gridpoint moves. A moment on the frame is taken from the sum in q. So
// forces and moments balance to rounding, and energy stays as it does with any force that has a potential. Viscosity of
// zones: g = K (u + beta du/dt) with du the whole change of u in the step. That is nothing in rigid motion however
// fast. Limits: linear elasticity for small turning, no force in rigid motion. Strain and turning inside of a block
// have to be small (kLargestDeformation). Else it goes zone by zone (zone_kernels.h), which differs by the square of
// the strain.
#pragma once

#include <span>

#include "model/lanes.h"
#include "model/world.h"
#include "model/zone_kernels.h"
#include "step/rigid_motion_kernels.h"

namespace quoin::blocks {

// A block as the kernels read and write it, by gridpoint.
struct LaneBlock {
  Vector *x, *v;          // m, m/s at half steps
  const double* force;    // N, four doubles a gridpoint, the last of no meaning
  const double* viscous;  // the viscous part of it, likewise; null where it is not needed, or not yet computed
  Vector acceleration;  // acceleration by weight and by loads that are shared by mass, over the mass for inertia, m/s2
  Vector moment;        // moment of point forces on the frame (gridpoint_kernels.h), N m
  int node_count;
  std::span<const ZoneLanes> zones;  // zones for distinct_forces, in the shape of the start
  BlockFrame* frame;                 // current frame; null: zone by zone
};

// Columns of up to kLanes blocks, a line a gridpoint. Gridpoints that a block does not have are without mass and force
// where its first one is. Lanes without a block hold numbers of no meaning. Scratch of a thread.
struct LaneColumns {
  int node_count = 0, fewest = 0;            // most and fewest of a block
  bool viscous = false;                      // viscous_force is requested: set before load_blocks
  double *x, *v, *force, *viscous_force;     // m, m/s, N
  double *u, *weighted, *product, *elastic;  // scratch of congruent_forces and distinct_forces
  double* moment;                            // a line, N m
  double* rows;                              // scratch of distinct_forces, for one block
  // FixedColumns; place and anchor of distinct_forces.
  const double *mass, *over_mass, *place, *anchor, *held, *held_v;

  void resize(int nodes);

 private:
  LaneVector<double> memory_;
};

void load_blocks(std::span<const LaneBlock> blocks, const FixedColumns<const double>& fixed, LaneColumns* columns);

// By lane: the largest |u|, m; strain energy, J, in steps with energies.
struct FrameSums {
  alignas(64) double deformation[kLanes], strain[kLanes];
};

// Adds internal forces to those in the columns.
void congruent_forces(std::span<const LaneBlock> blocks, const CongruentBlocks& congruent, const ZoneStep& step,
                      LaneColumns* columns, FrameSums* sums);
void distinct_forces(std::span<const LaneBlock> blocks, const ZoneStep& step, LaneColumns* columns, FrameSums* sums);

// How gridpoints are moved on.
struct GridpointStep {
  double time_step;        // s
  double gamma;            // coefficient of eq. 1, at gridpoints
  double alpha;            // mass-proportional viscosity, 1/s; with gamma = 0
  Vector ground;           // velocity of the ground, against which damping acts, m/s
  double inertia_factor;   // factor on the inertia of deformation
  double weight_per_mass;  // mass that has weight over mass of inertia
  Vector gravity;          // m/s2
  bool energies;           // work and kinetic energy are summed
  bool measured;           // whether net forces and energies are measured
};

// Frames follow the gridpoints. gains: of motion that is split; null: true inertia. shared: of congruent blocks, else
// null. sums: added to.
void advance_gridpoints(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                        const GridpointStep& step, const CongruentBlocks* shared, BlockSums* const* sums);

}  // namespace quoin::blocks
