// Rigid motion of deformable blocks as they stand, apart from their deformation, eight a vector: the equations of
// model/block_inertia.h. Compiled for every instruction set of Highway and chosen at run time.
#pragma once

#include <span>

#include "model/block_inertia.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct LaneColumns;

struct alignas(64) ByLane {
  double of[kLanes];
};

// Adds to the motion of gridpoints: linear + turning r, r from the centre of their block; m, m/s, 1/s.
struct RigidGains {
  ByLane centre[3], linear[3], turning[3][3];
};

// Motion of each block about its mass centre, for energies.
struct RigidLanes {
  ByLane mass, second[3][3];                           // kg; sum m r r^T, kg m2
  ByLane velocity[2][3], change[2][3], damping[2][3];  // linear and angular: before the step, in it; N, N m
  ByLane held[3];                                      // not 0: some gridpoint is, along that axis
};

struct RigidMotionStep {
  InertiaFactors factors;
  double gamma;      // coefficient of eq. 1 on rigid motion
  Vector ground;     // velocity of the ground, against which damping acts, m/s
  double time_step;  // s
};

// What a step adds to dt f/(s_b m), m/s, for the first `count` lanes. Two groups: lane by lane the halves of a unit;
// one: blocks that stand alone. gains, lanes: of each group; lanes may be null.
void split_motion(std::span<const LaneColumns> groups, int count, const RigidMotionStep& step, RigidGains* gains,
                  RigidLanes* lanes);

}  // namespace quoin::blocks
