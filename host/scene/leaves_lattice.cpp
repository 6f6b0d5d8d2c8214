#include "scene/leaves_lattice.h"

#include <fmt/core.h>

#include "scene/damping_text.h"

namespace quoin {

std::string leaves_lattice(const Scene& scene, std::size_t stage) {
  const Stage& settings = scene.stages[stage];
  if (!settings.ground) return settings.beyond_lattice();
  Stage others = settings;
  others.ground.reset();
  if (std::string acts = others.beyond_lattice(); !acts.empty()) return acts;
  const SolverSettings& solver = scene.solver_in(stage);
  if (solver.damping != DampingKind::impact && solver.damping != DampingKind::none)
    return fmt::format("moves the ground under damping = \"{}\"", name_of(solver.damping));
  if (solver.damping == DampingKind::impact && solver.maxwell_damping > 0.0)
    return "moves the ground under maxwell_damping";
  if (!settings.ground->supports.empty()) return "moves groups of supports";
  return "";
}

}  // namespace quoin
