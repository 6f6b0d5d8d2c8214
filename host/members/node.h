// A point of a block on which members act.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/local_damping.h"
#include "geometry/vector.h"

namespace quoin::members {

using geometry::Vector;

struct Node {
  int block = -1;
  Vector start;  // position at the start, m
  // Attachment to its block: place in the body frame of a rigid block, m; gridpoints and weights in a deformable one.
  Vector arm;
  std::vector<std::pair<std::int32_t, double>> share;
  bool turns = false;  // whether `turn` is computed
  // State in the current step:
  Vector x;               // m
  geometry::Matrix turn;  // rotation of the block since the start
  Vector force;           // force on the block, N
};

// Data of a step for nodes that members own.
struct Surroundings {
  double dt = 0.0;             // s
  Vector ground_way;           // motion of the ground in the last step, m
  Vector ground_velocity;      // velocity of the ground, relative to which damping acts, m/s
  Vector gravity;              // with the body force of a collapse stage, m/s2
  Vector of_collapse;          // that body force by mass, m/s2
  double mass_scaling = 1.0;   // inertia over mass
  double mass_damping = 0.0;   // 1/s
  double local_damping = 0.0;  // coefficient of eq. 1
  Vector ground;               // displacement of the ground since the start, m
  double jack = 0.0;           // share of pretensions, and of the weight of soil, that acts
};

// Advances one component of a node's velocity by a step; returns the work of damping, J. inertia: kg; force: N.
inline double brake(const Surroundings& step, double inertia, double force, double ground, double& v) {
  const double before = v, alpha = step.mass_damping * step.dt / 2.0;
  const double local = quoin::local_damping(step.local_damping, force, v - ground);
  v = (v * (1.0 - alpha) + step.dt / inertia * (force - local) + 2.0 * alpha * ground) / (1.0 + alpha);
  const double middle = 0.5 * (before + v);
  return (local + step.mass_damping * inertia * (middle - ground)) * middle * step.dt;
}

}  // namespace quoin::members
