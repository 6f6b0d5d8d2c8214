// Rigid motion of deformable blocks in their current positions, separate from their deformation, eight in a SIMD group:
// the equations of model/block_inertia.h. Compiled for every instruction set of Highway and chosen at run time.
#pragma once

#include <span>

#include "model/block_inertia.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct LaneColumns;

// Velocity added to gridpoints in a step: linear + turning r, r from the centre of their block; m, m/s, 1/s. In fixed
// frames r is the reference position from there, LaneColumns::arm.
struct RigidGains {
  ByLane centre[3], linear[3], turning[3][3];
};

// Motion of each block about its mass centre, for energies.
struct RigidLanes {
  InertiaLanes inertia;
  // Linear and angular: before the step; change in it; damping force and moment, N, N m.
  ByLane velocity[2][3], change[2][3], damping[2][3];
};

struct RigidMotionStep {
  InertiaFactors factors;
  double gamma;      // coefficient of eq. 1 on rigid motion
  Vector ground;     // velocity of the ground, against which damping acts, m/s
  double time_step;  // s
};

// Computes the velocity that a step adds to dt f/(s_b m), m/s, for the first `count` lanes. Two groups: the halves of
// units, lane by lane; one group: blocks that stand alone. gains, lanes: one a group; lanes may be null.
void split_motion(std::span<const LaneColumns> groups, int count, const RigidMotionStep& step, RigidGains* gains,
                  RigidLanes* lanes);

}  // namespace quoin::blocks
