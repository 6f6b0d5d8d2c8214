#include "model/motion.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "law/at_rest.h"
#include "law/property_text.h"
#include "scene/actions/actions.h"
#include "scene/from_bricks.h"
#include "scene/generate.h"
#include "scene/generate_blocks.h"
#include "scene/members.h"
#include "scene/read_masses.h"
#include "scene/to_bricks.h"

namespace quoin {

namespace {

[[noreturn]] void refuse(const Scene& scene, const std::string& what) {
  throw Error(Exit::bad_input, fmt::format("{}: {}", scene.file, what));
}

// Refuses settings that apply only to the lattice.
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

// First kind of item in the scene that the lattice cannot have; null: none.
const char* what_is_carried(const Scene& scene) {
  if (scene.building && has_walls_that_touch(*scene.building)) return "walls that touch without a [[building.corner]]";
  return scene.members ? "members" : !scene.masses.empty() ? "added masses" : nullptr;
}

// Reason why no part of the run of a wall or building can be on the lattice; empty: it can begin there.
std::string why_free_from_start(const Scene& scene) {
  if (const char* const carried = what_is_carried(scene)) return std::string("the scene has ") + carried;
  if (damping_of(scene.solver).has_maxwell()) return "solver.maxwell_damping";
  const std::string first = scene.stages.empty() ? "" : leaves_lattice(scene, 0);
  return first.empty() ? "" : fmt::format("stage '{}' {}", scene.stages.front().name, first);
}

// What of a stage acts along z, as messages have it; null: nothing does.
const char* acts_along_z(const Stage& stage) {
  const auto moves = [](const GroundMotion& ground) {
    return std::ranges::any_of(ground.components, [](const auto& c) { return c.direction[2] != 0.0; });
  };
  if (stage.ground && (moves(*stage.ground) || std::ranges::any_of(stage.ground->supports, moves)))
    return "moves the ground";
  if (stage.collapse && stage.collapse->direction[2] != 0.0) return "pushes to collapse";
  if (stage.gravity[2] != 0.0) return "has gravity";
  if (std::ranges::any_of(stage.controls, [](const BodyControl& c) {
        return c.force[2] != 0.0 || c.velocity[2] != 0.0 || c.in_cycles == 2;
      }))
    return "moves or loads a body";
  if (std::ranges::any_of(stage.forces, [](const PointForce& f) { return f.force[2] != 0.0; })) return "has a force";
  if (stage.moving_load && stage.moving_load->force[2] != 0.0) return "has a moving load";
  if (std::ranges::any_of(stage.pressures, [](const FacePressure& p) { return p.normal[2] != 0.0; }))
    return "has a pressure";
  return nullptr;
}

// A wall of half thickness cannot move across its plane of symmetry.
void refuse_loads_across_symmetry(const Scene& scene) {
  if (!scene.wall || !scene.wall->half_thickness) return;
  for (const Stage& stage : scene.stages) {
    if (const char* const acts = acts_along_z(stage))
      throw Error(Exit::bad_input,
                  fmt::format("{}: stage '{}' {} along z, across the plane of symmetry of a wall with half_thickness = "
                              "true; make that false",
                              stage.source.text, stage.name, acts));
  }
}

// Prepares a scene whose stages the lattice does not all have. A run changes to large motion when the first such stage
// begins.
void prepare_for_free_blocks(const Scene& scene, Assembly& bricks) {
  refuse_loads_across_symmetry(scene);
  const Stage* beyond = nullptr;
  std::string why;
  for (std::size_t i = 0; i < scene.stages.size() && !beyond; ++i) {
    why = leaves_lattice(scene, i);
    if (!why.empty()) beyond = &scene.stages[i];
  }
  const char* const carried = what_is_carried(scene);
  if (!beyond && !carried && !stands_on_ground(scene)) return;
  const SolverSettings& s = scene.solver;
  const char* const against = s.kernels == Kernels::lattice          ? "kernels = \"lattice\""
                              : s.large_motion == LargeMotion::never ? "large_motion = \"never\""
                              : s.selective_time_step > 0.0          ? "selective_time_step"
                                                                     : nullptr;
  if (against && (beyond || carried))
    throw Error(Exit::bad_input,
                fmt::format("{}, which takes blocks in large motion and is not to be had with solver.{}; remove that "
                            "setting",
                            beyond ? fmt::format("{}: stage '{}' {}", beyond->source.text, beyond->name, why)
                                   : fmt::format("{}: the scene has {}", scene.file, carried),
                            against));
  if (!stands_on_ground(scene)) return;
  stand_on_ground(scene, bricks);
  check_stages(scene, blocks::from_bricks(bricks));
}

// Refuses stages that blocks of any shape cannot have, or members.
void refuse_stages(const Scene& scene) {
  if (damping_of(scene.solver).is_implicit())
    refuse(scene,
           "solver.implicit_contacts is for blocks on the lattice, and this scene runs in the general kernels; remove "
           "it from [solver]");
  for (const Stage& stage : scene.stages) {
    if (stage.solver && damping_of(*stage.solver).is_implicit())
      throw Error(
          Exit::bad_input,
          fmt::format("{}: stage '{}': solver.implicit_contacts is for blocks on the lattice, and this scene runs in "
                      "the general kernels; remove it from the stage",
                      stage.source.text, stage.name));
    if (scene.members && stage.kind == "rest")
      throw Error(
          Exit::bad_input,
          fmt::format("{}: a stage of rest does not have the forces of members ([[tie]], [[spring]], [[strip]], "
                      "[[floor]], [[beam]], [[dowel]], [[fill]]); give it equilibrium_ratio without kind = "
                      "\"rest\"",
                      stage.source.text));
    for (const auto& [family, law] : stage.law_swaps) refuse_swap_of_strips(scene, family, stage.source.text);
  }
}

Motion as_blocks(Scene scene, blocks::Assembly shapes) {
  refuse_stages(scene);
  add_masses(scene, &shapes);
  Motion motion{std::move(scene), {}, std::move(shapes), {}};
  motion.bricks.materials = motion.shapes->materials;
  motion.bricks.families = motion.shapes->families;
  return motion;
}

}  // namespace

void refuse_swap_of_strips(const Scene& scene, const std::string& family, const std::string& where) {
  for (std::size_t i = 0; scene.members && i < scene.members->strips.size(); ++i) {
    if (const StripSpec& strip = scene.members->strips[i]; strip.joint == family)
      throw Error(
          Exit::bad_input,
          fmt::format("{}: the law of joint family '{}' is to be swapped, which bonds the strip '{}': strips keep "
                      "their law; give law as a table of the other families",
                      where, family, strip.name));
  }
}

std::string fault_of_law_swap(const JointFamily& family, const Stage& stage) {
  if (!family.scatters()) return "";
  return fmt::format(
      "{}: the law of joints.{} is replaced in stage '{}', and its properties scatter: a law takes over states for one "
      "set of properties only; remove the distributions or the change of laws",
      stage.source.text, family.name, stage.name);
}

namespace {

// Whether an edge that carries all of the load may crush. At corners alone, a quarter of the face each, it could not
// before half of the face is at its strength.
bool may_crush(const Material& material) {
  return find_property(material.api(), "compressive_strength") &&
         std::isfinite(material.number("compressive_strength"));
}

}  // namespace

void choose_rigid_points(const Scene& scene, std::vector<JointFamily>* families) {
  for (JointFamily& family : *families) {
    const Material material(Law::find(family.law), family.properties);
    if (scene.cubic_points)
      family.rigid_points = *scene.cubic_points ? RigidPoints::cubic : RigidPoints::corners;
    else if (carries_tension(material, family.initial_state) || may_crush(material))
      family.rigid_points = RigidPoints::cubic_at_start;
    else
      family.rigid_points = RigidPoints::corners;
  }
}

Motion choose_motion(Scene scene, Assembly bricks) {
  if (scene.blocks) refuse(scene, "bricks given in place of blocks of any shape");
  choose_rigid_points(scene, &bricks.families);
  prepare_for_free_blocks(scene, bricks);
  const std::string begins_free = why_free_from_start(scene);
  const bool at_once = scene.solver.large_motion == LargeMotion::always || !begins_free.empty();
  if (!at_once && scene.solver.kernels != Kernels::general) return {std::move(scene), std::move(bricks), {}, {}};
  blocks::Assembly shapes = blocks::from_bricks(bricks);
  refuse_settings_of_the_lattice(scene, shapes,
                                 !begins_free.empty() ? begins_free
                                 : at_once            ? "solver.large_motion = \"always\""
                                                      : "solver.kernels = \"general\"");
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
  check_stages(scene, shapes);
  choose_rigid_points(scene, &shapes.families);
  std::string why_not;
  std::optional<blocks::OnLattice> found;
  if (const char* const carried = what_is_carried(scene))
    why_not = std::string("the scene has ") + carried;
  else
    found = blocks::to_bricks(shapes, scene, &why_not);
  const Kernels kernels = scene.solver.kernels;
  if (!found && kernels == Kernels::lattice) refuse(scene, "solver.kernels = \"lattice\": " + why_not);
  if (found && kernels != Kernels::general) return {std::move(found->scene), std::move(found->bricks), {}, {}};
  if (found) why_not = "solver.kernels = \"general\"";
  refuse_settings_of_the_lattice(scene, shapes, why_not);
  if (scene.solver.large_motion == LargeMotion::never && !scene.solver.motion_bound.stop)
    refuse(scene, fmt::format("solver.past_motion_bound = \"warn\" is of the lattice, where these blocks do not move: "
                              "{}; past the bound they move in large motion; leave out large_motion = \"never\"",
                              why_not));
  Motion motion = as_blocks(std::move(scene), std::move(shapes));
  motion.why_not_lattice = why_not;
  return motion;
}

}  // namespace quoin
