// Clock of a run, and its time step.
#pragma once

#include <functional>
#include <span>

#include "geometry/vector.h"
#include "scene/scene.h"

namespace quoin::blocks {

struct World;

using geometry::Vector;

// Steps advance the clock. The time step is chosen again when stiffness, inertia or settings change.
struct Stepping {
  double time = 0.0;                   // s
  long count = 0;                      // number of steps
  double dt = 0.0, critical_dt = 0.0;  // s; critical: 2/omega_max of the assembled system, undamped
  double stiffness_bound = 0.0;        // local bound of contacts, when omega_max was computed, 1/s2
  double omega = 0.0;                  // highest frequency of blocks and joints at that time, rad/s
  double springs = 0.0;                // eigenvalue of external springs, 1/s2
};

// Place that sets the time step: a rigid block, or a gridpoint and the flattest zone at it.
struct StepLimit {
  int block = -1;
  Vector at;                                 // m
  double height = 0.0, shortest_edge = 0.0;  // height and shortest edge of the zone, m; 0: a rigid block
};

// The time step with these settings over the critical one. critical: without damping, s.
double step_over_critical(const SolverSettings& solver, double critical);

// Place of the largest motion in the fastest vibration. Only for a process that has all blocks.
StepLimit what_sets_time_step(const World& w);
// Computes the critical step and the step. The step in use becomes shorter, or longer only if it may grow.
void find_time_step(World& w, bool may_grow = false);
bool shorten_step(const World& w, std::span<const int> changed);  // changed: own blocks
double local_stiffness_bound(const World& w, const std::function<bool(int block)>& is_wanted);

}  // namespace quoin::blocks
