#include "scene/quality.h"

namespace quoin {
namespace {

// Damping by block and slow deformation: time steps of a block on its joints, three times those of its zones. Less
// damping than eq. 1's 0.8 because local damping multiplies the inertia of what speeds up by 1/(1 - gamma): faster
// loading for the same error.
SolverSettings by_block() {
  SolverSettings s;
  s.damping = DampingKind::block;
  s.local_damping = 0.5;
  s.deformation_inertia = 16.0;
  s.time_step_fraction = 0.8;
  return s;
}

// The paper's way: eq. 1 everywhere, true inertia, small steps.
SolverSettings as_printed() {
  SolverSettings s;
  s.time_step_fraction = 0.4;
  return s;
}

}  // namespace

const std::vector<Quality>& qualities() {
  static const std::vector<Quality> all{{"fast", by_block(), 0.08, 1e-3, 0.035, 0.15, 0.10},
                                        {"standard", by_block(), 0.04, 1e-3, 0.015, 0.11, 0.06},
                                        {"reference", as_printed(), 0.0025, 1e-4, 0.005, 0.015, 0.005}};
  return all;
}

const Quality& quality_named(const std::string& name) {
  for (const Quality& q : qualities()) {
    if (q.name == name) return q;
  }
  return qualities()[1];
}

}  // namespace quoin
