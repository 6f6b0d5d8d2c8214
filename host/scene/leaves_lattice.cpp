#include "scene/leaves_lattice.h"

namespace quoin {

std::string leaves_lattice(const Scene& scene, std::size_t stage) {
  const Stage& settings = scene.stages[stage];
  if (!settings.ground) return settings.beyond_lattice();
  Stage others = settings;
  others.ground.reset();
  if (std::string acts = others.beyond_lattice(); !acts.empty()) return acts;
  const SolverSettings& solver = scene.solver_in(stage);
  // The lattice has no viscous damping of joints.
  if (solver.damping == DampingKind::viscous && solver.stiffness_damping > 0.0)
    return "moves the ground under stiffness_damping";
  if (solver.damping == DampingKind::impact && solver.maxwell_damping > 0.0)
    return "moves the ground under maxwell_damping";
  return "";
}

}  // namespace quoin
