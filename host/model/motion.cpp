#include "model/motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "scene/from_bricks.h"
#include "scene/generate.h"
#include "scene/generate_blocks.h"
#include "scene/to_bricks.h"

namespace quoin {

namespace {

[[noreturn]] void refuse(const Scene& scene, const std::string& what) {
  throw Error(Exit::bad_input, fmt::format("{}: {}", scene.file, what));
}

// Settings that blocks of any shape have no meaning for.
void refuse_settings_of_the_lattice(const Scene& scene, const blocks::Assembly& shapes, const std::string& why_not) {
  const bool in_units =
      std::any_of(shapes.blocks.begin(), shapes.blocks.end(), [](const blocks::Block& b) { return b.unit >= 0; });
  const SolverSettings& s = scene.solver;
  const SolverSettings usual;
  const std::pair<const char*, bool> settings[] = {
      {"unit_inertia", s.unit_inertia != usual.unit_inertia && scene.quality.empty() && !in_units},
      {"critical_time_step", s.critical_time_step != usual.critical_time_step},
  };
  for (const auto& [name, asked] : settings) {
    if (!asked) continue;
    refuse(scene, fmt::format("solver.{} is of the lattice, where these blocks do not move: {}; remove the setting",
                              name, why_not));
  }
}

Motion as_blocks(Scene scene, blocks::Assembly shapes) {
  Motion motion{std::move(scene), {}, std::move(shapes), {}};
  motion.bricks.materials = motion.shapes->materials;
  motion.bricks.families = motion.shapes->families;
  return motion;
}

}  // namespace

Motion choose_motion(Scene scene, Assembly bricks) {
  if (scene.blocks) refuse(scene, "bricks given in place of blocks of any shape");
  const bool at_once = scene.solver.large_motion == LargeMotion::always;
  if (!at_once && scene.solver.kernels != Kernels::general) return {std::move(scene), std::move(bricks), {}, {}};
  blocks::Assembly shapes = blocks::from_bricks(bricks);
  refuse_settings_of_the_lattice(scene, shapes,
                                 at_once ? "solver.large_motion = \"always\"" : "solver.kernels = \"general\"");
  if (!at_once) shapes.contact.small_displacement = blocks::ContactSettings{}.small_displacement;
  Motion motion = as_blocks(std::move(scene), std::move(shapes));
  motion.bricks.symmetry_factor = bricks.symmetry_factor;
  return motion;
}

Motion choose_motion(Scene scene) {
  if (!scene.blocks) {
    Assembly bricks = assemble(scene);
    return choose_motion(std::move(scene), std::move(bricks));
  }
  blocks::Assembly shapes = blocks::assemble(scene);
  std::string why_not;
  std::optional<blocks::OnLattice> found = blocks::to_bricks(shapes, scene, &why_not);
  const Kernels kernels = scene.solver.kernels;
  if (!found && kernels == Kernels::lattice) refuse(scene, "solver.kernels = \"lattice\": " + why_not);
  if (found && kernels != Kernels::general) return {std::move(found->scene), std::move(found->bricks), {}, {}};
  if (found) why_not = "solver.kernels = \"general\"";
  refuse_settings_of_the_lattice(scene, shapes, why_not);
  Motion motion = as_blocks(std::move(scene), std::move(shapes));
  motion.why_not_lattice = why_not;
  return motion;
}

}  // namespace quoin
