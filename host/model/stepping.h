// The clock of a run, and what sets its time step.
#pragma once

#include <functional>
#include <span>

#include "geometry/vector.h"
#include "scene/scene.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// Steps move it on; the time step is chosen again where stiffness, inertia or settings change.
struct Stepping {
  double time = 0.0;                   // s
  long count = 0;                      // number of steps
  double dt = 0.0, critical_dt = 0.0;  // s; 2/omega_max of the assembled system, undamaged
  double stiffness_bound = 0.0;        // local, of contacts, when omega_max was found, 1/s2
  double springs = 0.0;                // eigenvalue of springs from outside, 1/s2
};

// A rigid block, or a gridpoint and the flattest zone at it.
struct StepLimit {
  int block = -1;
  Vector at;                                 // m
  double height = 0.0, shortest_edge = 0.0;  // height and shortest edge of the zone, m; 0: a rigid block
};

// The time step with these settings over the critical one, s, without damping.
double step_over_critical(const SolverSettings& solver, double critical);

// What moves most in the fastest vibration, which sets the step; of one process that has all blocks.
StepLimit what_sets_time_step(const World& w);
// Beside the one in use, which falls alone unless it may grow.
void find_time_step(World& w, bool may_grow = false);
bool shorten_step(const World& w, std::span<const int> changed);  // these own blocks
double local_stiffness_bound(const World& w, const std::function<bool(int block)>& is_wanted);

}  // namespace quoin::blocks
