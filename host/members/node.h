// A point of a block that members pull at.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

struct Node {
  int block = -1;
  Vector start;  // m
  // How it moves with its block: of a rigid one in the body frame, m; of a deformable one gridpoints and weights.
  Vector arm;
  std::vector<std::pair<std::int32_t, double>> share;
  bool turns = false;  // whether `turn` is used
  // State in the current step:
  Vector x;               // m
  geometry::Matrix turn;  // rotation of the block since the start
  Vector force;           // force on the block, N
};

// What a step adds to nodes that members have of their own.
struct Surroundings {
  double dt = 0.0;             // s
  Vector ground_way;           // motion in the last step, m
  Vector ground_velocity;      // velocity of the ground, against which damping acts, m/s
  Vector gravity;              // m/s2
  double mass_scaling = 1.0;   // inertia over mass
  double mass_damping = 0.0;   // 1/s
  double local_damping = 0.0;  // coefficient of eq. 1
};

// One component of a node's velocity, on by a step. Returns what damping has taken, J. inertia: kg; force: N.
inline double brake(const Surroundings& step, double inertia, double force, double ground, double& v) {
  const double before = v, alpha = step.mass_damping * step.dt / 2.0;
  const double local = v == ground ? 0.0 : std::copysign(step.local_damping * std::abs(force), v - ground);
  v = (v * (1.0 - alpha) + step.dt / inertia * (force - local) + 2.0 * alpha * ground) / (1.0 + alpha);
  const double middle = 0.5 * (before + v);
  return (local + step.mass_damping * inertia * (middle - ground)) * middle * step.dt;
}

}  // namespace quoin::members
