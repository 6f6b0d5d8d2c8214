#include "scene/leaves_lattice.h"

namespace quoin {

std::string leaves_lattice(const Scene& scene, std::size_t stage) {
  const Stage& settings = scene.stages[stage];
  if (!settings.ground) return beyond_lattice(settings);
  Stage others = settings;
  others.ground.reset();
  if (std::string acts = beyond_lattice(others); !acts.empty()) return acts;
  return damping_of(scene.solver_in(stage)).has_maxwell() ? "moves the ground under maxwell_damping" : "";
}

}  // namespace quoin
