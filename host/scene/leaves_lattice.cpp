#include "scene/leaves_lattice.h"

namespace quoin {

std::string leaves_lattice(const Scene& scene, std::size_t stage) {
  Stage others = scene.stages[stage];
  const bool shakes = others.ground.has_value();
  others.ground.reset();
  if (std::string acts = beyond_lattice(others); !acts.empty()) return acts;
  if (!damping_of(scene.solver_in(stage)).has_maxwell()) return "";
  return shakes ? "moves the ground under maxwell_damping" : "has maxwell_damping";
}

}  // namespace quoin
