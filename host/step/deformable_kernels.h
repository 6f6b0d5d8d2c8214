// Deformable blocks in large motion, eight in a SIMD group: their internal forces, and the motion of their gridpoints.
// Internal forces come from a stiffness in the co-rotational frame, which congruent blocks share. Compiled for every
// instruction set of Highway and chosen at run time. Lanes are independent: a block's results are bitwise identical in
// any group.
//
// Frames of blocks. X: reference positions of corners from their mass centre, m: their masses, x: current positions;
//   b = m S^-1 X,  S = sum m X X^T,   F = sum x b^T = R U (polar).
// For all gridpoints, c: the mass centre, u = R^T (x - c) - X. Other gridpoints have b = 0.
// The strain energy 1/2 u . K u has the forces
//   f = -R (g - q x b),  g = K u,  q = (tr(U) 1 - U)^-1 sum (X + u) x g;
// The second part of f is due to the rotation of R when a gridpoint moves. A moment on the frame is subtracted from the
// sum in q. So forces and moments balance to rounding, and the forces have a potential. Viscosity of zones: g = K (u +
// beta du/dt). The change du of u in the step is 0 in rigid motion at any speed. Limits: linear elasticity for small
// rotations, no force in rigid motion. Strains and rotations within a block must be small (kLargestDeformation). Else
// its forces are computed zone by zone (zone_kernels.h), which differs by the square of the strain.
#pragma once

#include <span>

#include "model/lanes.h"
#include "model/world.h"
#include "model/zone_kernels.h"
#include "step/rigid_motion_kernels.h"

namespace quoin::blocks {

// A block as the kernels read and write it; arrays by gridpoint.
struct LaneBlock {
  Vector *x, *v;          // position, m; velocity at half steps, m/s
  const double* force;    // N, four doubles a gridpoint, the last one unused; null, in all blocks of a group: no force
  const double* viscous;  // viscous part of force; null: not needed, or not yet computed
  // Weight, and loads distributed by mass, over the mass for inertia, m/s2.
  Vector acceleration;
  int node_count;
  std::span<const ZoneLanes> zones;  // zones in the reference shape, for distinct_forces
  BlockFrame* frame;  // current frame, which follows the block; null: forces zone by zone, or small displacements
};

// Columns of up to kLanes blocks, one line a gridpoint. Missing gridpoints of a block have no mass and no force, and
// lie at its first one. Lanes without a block have undefined values. Scratch of a thread.
struct LaneColumns {
  int node_count = 0, fewest = 0;            // largest and smallest number of gridpoints of a block
  bool viscous = false;                      // whether viscous_force is computed: set before load_blocks
  double *x, *v;                             // m, m/s
  double *force, *viscous_force;             // N
  double *u, *weighted, *product, *elastic;  // scratch of congruent_forces and distinct_forces
  double* moment;                            // one line: of contact forces on the frames (contact_kernels.h), N m
  double* rows;                              // scratch of distinct_forces, for one block
  // FixedColumns; place and anchor for distinct_forces; arm is null where frames follow their blocks.
  const double *mass, *over_mass, *place, *anchor, *held_v, *arm;
  const FixedFrameLanes* at_start;  // of blocks in fixed frames; else null

  void resize(int nodes, double* motion);  // motion: memory for x and v, as in KeptMotion

 private:
  LaneVector<double> memory_;
};

// Memory in which positions and velocities of a group stay in lanes from step to step. For blocks with as many
// gridpoints as each other.
struct KeptMotion {
  double* memory = nullptr;  // 2 kLine numbers a gridpoint; null: scratch
  bool is_current = false;   // whether the last step has left them there
};

void load_blocks(std::span<const LaneBlock> blocks, const FixedColumns<const double>& fixed, const KeptMotion& kept,
                 LaneColumns* columns);

// Sums of three numbers by lane.
struct LaneSums {
  alignas(64) double of[3][kLanes];
  Vector lane(std::size_t l) const { return {of[0][l], of[1][l], of[2][l]}; }
};

// Adds the forces of contact points on gridpoints of `count` blocks to those in the columns, and sums their moments on
// the frames. Returns the sums of the forces, N.
LaneSums add_gridpoint_lines(std::span<const GridpointLine> lines, std::span<const RowLine> moments,
                             const FacetRow* rows, std::size_t count, LaneColumns* columns);

// By lane: largest |u|, m; strain energy, J, in steps with energies.
struct FrameSums {
  alignas(64) double deformation[kLanes], strain[kLanes];
};

// A group of blocks in frames, its columns, and what internal forces give beside them.
struct FramedGroup {
  std::span<const LaneBlock> blocks;
  LaneColumns* columns;
  FrameSums* sums;
};

// Add internal forces to the forces in the columns. groups: one or two of the same shape. fixed_frame_forces: of blocks
// in fixed frames R, -R K u with u = R^T (x - x_0) up to a translation, x_0 the reference position.
void fixed_frame_forces(std::span<const FramedGroup> groups, const CongruentBlocks& congruent, const ZoneStep& step);
void congruent_forces(std::span<const FramedGroup> groups, const CongruentBlocks& congruent, const ZoneStep& step);
void distinct_forces(const FramedGroup& group, const ZoneStep& step);

// Parameters of the motion of gridpoints in a step.
struct GridpointStep {
  double time_step;        // s
  double gamma;            // coefficient of eq. 1, at gridpoints
  double alpha;            // mass-proportional viscosity, 1/s; with gamma = 0
  Vector ground;           // velocity of the ground, against which damping acts, m/s
  double inertia_factor;   // factor on the inertia of deformation
  double weight_per_mass;  // mass for weight over mass for inertia
  Vector gravity;          // m/s2
  bool energies;           // whether work and kinetic energy are summed
  bool measured;           // whether net forces and energies are measured
  bool velocities;         // whether velocities are copied from lanes to the blocks
};

// Moves gridpoints by a step, and updates the frames. gains: rigid part of the motion where inertia is scaled; null:
// true inertia. shared: shape of congruent blocks, else null. Adds to sums, one a
// block.
void advance_gridpoints(std::span<const LaneBlock> blocks, const LaneColumns& columns, const RigidGains* gains,
                        const GridpointStep& step, const CongruentBlocks* shared, BlockSums* sums);

}  // namespace quoin::blocks
