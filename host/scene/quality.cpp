#include "scene/quality.h"

#include "base/error.h"

namespace quoin {
namespace {

// Damping by block, and added inertia against vibrations inside units. So time steps are those of a unit on its joints,
// five times those of zones. Damping is low, because local damping multiplies the inertia of accelerating motion by
// 1/(1 - gamma). A wall with delayed cracks follows another path after its drops (benchmarks/README.md). No motion has
// a period of 4 steps or less. Eq. 1 would amplify such motion in drifting blocks, as the units of a rocking pier. With
// damping ratio d at omega_max the step is 0.86 (sqrt(1 + d^2) - d) = 0.705 of 2/omega_max, below 1/sqrt(2).
SolverSettings by_block() {
  SolverSettings s;
  s.damping = DampingKind::block;
  s.local_damping = 0.3;
  s.settling_damping = 0.5;
  s.deformation_damping = 0.2;
  s.deformation_inertia = 64.0;
  s.unit_inertia = 16.0;
  s.time_step_fraction = 0.86;
  return s;
}

// Settings of the paper: eq. 1 everywhere, true inertia, small steps.
SolverSettings as_printed() {
  SolverSettings s;
  s.time_step_fraction = 0.4;
  return s;
}

}  // namespace

const std::vector<Quality>& qualities() {
  static const std::vector<Quality> all{{"fast", by_block(), 0.04, 1e-3, 0.02, 0.12, 0.06},
                                        {"standard", by_block(), 0.02, 1e-3, 0.015, 0.08, 0.015},
                                        {"reference", as_printed(), 0.0025, 1e-4, 0.005, 0.015, 0.005}};
  return all;
}

const Quality& quality_named(const std::string& name) {
  for (const Quality& q : qualities()) {
    if (q.name == name) return q;
  }
  std::string names;
  for (const Quality& q : qualities()) names += (names.empty() ? "" : ", ") + q.name;
  throw Error(Exit::bad_input, "no quality '" + name + "'; there are " + names);
}

}  // namespace quoin
