// Rigid blocks in large motion: contact points of a pair, and bodies, in SIMD groups. Compiled for every instruction
// set of Highway and chosen at run time.
//
// Once a pair, with R_a, R_b the orientations, x_a, x_b the centres and e_n, e_s, e_t the plane's axes in a's frame:
//   position of a point along axis k = base_k + col_k . arm,  base_k = e_k . R_a^T (x_b - x_a),  col_k = R_b^T R_a e_k.
// So a point costs nine multiplications. Its force, in the same axes at the same position, is added to the wrench of
// the pair.
#pragma once

#include <cstdint>
#include <span>

#include "model/chunks.h"
#include "model/motion_checks.h"
#include "model/pieces.h"
#include "model/rigid_bodies.h"
#include "model/step_sums.h"
#include "step/point_kernels.h"

namespace quoin::blocks {

// Columns are those of a family, beginning at its first point. Computes openings and slip increments of the step, and
// positions along s and t for the next one.
void rigid_jumps(std::span<RigidPair> pairs, const Body* bodies, const PointColumns& columns);

// Computes forces and moments of each pair from the tractions, at the positions of rigid_jumps.
void rigid_forces(std::span<RigidPair> pairs, const Body* bodies, const PointColumns& columns);

// Parameters of the motion of bodies in a step.
struct BodyStep {
  double time_step;  // s
  double gamma;      // coefficient of eq. 1
  double alpha;      // mass-proportional viscosity, 1/s; with gamma = 0
  Vector ground;     // velocity of the ground, against which damping acts, m/s
  Vector gravity;    // m/s2
  bool energies;     // whether work and kinetic energy are summed
};

// Advances bodies[index[0 .. count - 1]], at most kBodies, by central differences from their force and torque. sums:
// one for each of these, all written. assumed: motion at the last check, parallel to bodies; null: no check so far.
void advance_rigid(Body* bodies, const AssumedMotion* assumed, const std::int32_t* index, int count,
                   const BodyStep& step, BlockSums* const* sums);

}  // namespace quoin::blocks
