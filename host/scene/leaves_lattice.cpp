#include "scene/leaves_lattice.h"

namespace quoin {

std::string leaves_lattice(const Scene& scene, std::size_t stage) {
  const Stage& settings = scene.stages[stage];
  if (!settings.ground) return beyond_lattice(settings);
  Stage others = settings;
  others.ground.reset();
  if (std::string acts = beyond_lattice(others); !acts.empty()) return acts;
  const Damping damping = damping_of(scene.solver_in(stage));
  // The lattice has no damping of joints in proportion to stiffness, and no Maxwell elements.
  if (damping.beta > 0.0) return "moves the ground under stiffness_damping";
  return damping.has_maxwell() ? "moves the ground under maxwell_damping" : "";
}

}  // namespace quoin
