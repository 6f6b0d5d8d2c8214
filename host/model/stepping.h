// The clock of a run, and what sets its time step.
#pragma once

#include <cstddef>
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

// Rigid motion is advanced apart from the rest: inertia is scaled apart, or damping is by block.
inline bool splits_motion(const SolverSettings& s) {
  return s.damping == DampingKind::block || s.deformation_inertia != 1.0 || s.unit_inertia != 1.0;
}
inline bool impacts_damped(const SolverSettings& s) { return s.damping == DampingKind::impact; }
inline bool has_maxwell(const SolverSettings& s) { return impacts_damped(s) && s.maxwell_damping > 0.0; }
inline bool viscous_contacts(const SolverSettings& s) {
  return impacts_damped(s) || (s.damping == DampingKind::viscous && s.stiffness_damping > 0);
}

// Beside the one in use, which falls alone unless it may grow.
void find_time_step(World& w, bool may_grow = false);
bool shorten_step(const World& w, std::span<const int> changed);  // these own blocks
double local_stiffness_bound(const World& w, const std::function<bool(int block)>& is_wanted);

}  // namespace quoin::blocks
