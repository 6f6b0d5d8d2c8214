#include "scene/unused_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "scene/block_kinds.h"
#include "scene/driven.h"
#include "scene/generate.h"
#include "scene/members.h"
#include "scene/quality.h"

namespace quoin {

namespace {

using Names = std::set<std::string>;

Names materials_in_use(const Scene& scene) {
  Names names;
  const auto add_lintels = [&](const std::vector<WallSpec::Opening>& openings) {
    for (const WallSpec::Opening& opening : openings) names.insert(opening.lintel_material);
  };
  if (scene.wall) {
    names.insert(scene.wall->unit_material);
    for (const WallSpec::Changed& changed : scene.wall->changed) names.insert(changed.material);
    add_lintels(scene.wall->openings);
  }
  if (scene.building) {
    names.insert(scene.building->unit_material);
    for (const BuildingSpec::Wall& wall : scene.building->walls) add_lintels(wall.openings);
  }
  if (scene.blocks) {
    for (const BlockSpec& block : scene.blocks->blocks) names.insert(block.material);
    for (const DryWallSpec& wall : scene.blocks->walls) names.insert(wall.material);
    for (const ArchSpec& arch : scene.blocks->arches) names.insert(arch.material);
  }
  return names;
}

Names joints_in_use(const Scene& scene) {
  Names names;
  const auto add = [&](const auto& masonry, bool has_mid_unit_joints) {
    names.insert({masonry.bed_joint, masonry.head_joint, masonry.beam_joint});
    if (has_mid_unit_joints) names.insert(masonry.unit_joint);
  };
  if (scene.wall) add(*scene.wall, scene.wall->mid_unit_joints);
  if (scene.building) add(*scene.building, true);
  if (scene.blocks) {
    names.insert(scene.blocks->default_joint);
    for (const JointRule& rule : scene.blocks->rules) names.insert(rule.family);
  }
  if (scene.members) {
    for (const StripSpec& strip : scene.members->strips) names.insert(strip.joint);
  }
  return names;
}

// Whether a unit may have several blocks.
bool has_parted_units(const Scene& scene) {
  const auto& blocks = scene.blocks;
  return scene.building || (scene.wall && scene.wall->mid_unit_joints) ||
         (blocks && (std::ranges::any_of(blocks->walls, &DryWallSpec::mid_unit_joints) ||
                     std::ranges::any_of(blocks->blocks, [](const BlockSpec& b) { return !b.mesh.empty(); })));
}

// add_if(is unused, key, why).
template <class AddIf>
void add_unused_of_wall(const Scene& scene, const AddIf& add_if) {
  if (!scene.wall) return;
  const WallSpec usual;
  const WallSpec& wall = *scene.wall;
  if (!wall.bottom_beam && !wall.top_beam) {
    const char* const no_beam = "the wall has no beam";
    add_if(wall.beam_height != usual.beam_height, "wall.beam_height", no_beam);
    add_if(wall.beam_density != usual.beam_density, "wall.beam_density", no_beam);
  }
  add_if(!wall.mid_unit_joints && !wall.unit_joint.empty(), "wall.unit_joint", "wall.mid_unit_joints = false");
}

template <class AddIf>
void add_unused_of_beam(const BeamSpec& beam, const AddIf& add_if) {
  const BeamSpec usual;
  const auto is_held = [&](const char* how) {
    return beam.bedding == how || std::ranges::any_of(beam.supports, [&](const auto& s) { return s.hold == how; });
  };
  const auto add = [&](bool is_unused, const char* key, const char* why) {
    add_if(is_unused, fmt::format("beam.{}.{}", beam.name, key), why);
  };
  add(!is_held("resting") && beam.friction != usual.friction, "friction", "it rests on no support");
  if (beam.inertia[0] > 0.0) return;
  const char* const cable = "inertia = 0 makes it a cable";
  const bool twists = beam.torsion > 0.0 && is_held("built_in");
  add(beam.shear_area != usual.shear_area, "shear_area", cable);
  add(beam.yield_moment != usual.yield_moment, "yield_moment", cable);
  add(!twists && beam.torsion > 0.0, "torsion", cable);
  add(!twists && beam.poisson_ratio != usual.poisson_ratio, "poisson_ratio", cable);
  add(beam.up != usual.up && !piece_along(beam, usual.up), "up", cable);
}

// Whether a support stays in its place in all stages.
bool never_moves(const Scene& scene, const std::string& name) {
  const auto moves = [&](const BodyControl& c) {
    return c.body == name && (prescribed_by(c) != kAllPrescribed || moves_body(c));
  };
  const bool is_support =
      is_ground(scene, name) || (scene.blocks && std::ranges::any_of(scene.blocks->blocks, [&](const BlockSpec& b) {
                                   return b.fixed && b.name == name;
                                 }));
  return is_support && std::ranges::none_of(scene.stages, [&](const Stage& stage) {
           return stage.ground || std::ranges::any_of(stage.controls, moves);
         });
}

template <class AddIf>
void add_unused_of_members(const Scene& scene, const MemberSpecs& members, const AddIf& add_if) {
  for (const SpringSpec& spring : members.springs)
    add_if(never_moves(scene, spring.block), fmt::format("spring.{}", spring.name),
           "all stages hold its block in its place; free it with [[stage.control]]");
  for (const SpringSpec& spring : members.springs)
    add_if(spring.shear_stiffness == 0.0 && spring.friction_angle != SpringSpec().friction_angle,
           fmt::format("spring.{}.friction_angle", spring.name), "shear_stiffness = 0: no shear is limited");
  for (const FloorSpec& floor : members.floors) {
    const bool slides =
        floor.connector_stiffness > 0.0 && (std::isfinite(floor.connector_strength) || std::isfinite(floor.pull_out));
    add_if(!slides && floor.friction != 0.0, fmt::format("floor.{}.connector.friction", floor.name),
           floor.connector_stiffness > 0.0 ? "without shear_strength and pull_out the connector never slides"
                                           : "shear_stiffness = 0: no shear is limited");
  }
  for (const BeamSpec& beam : members.beams) add_unused_of_beam(beam, add_if);
}

}  // namespace

std::vector<std::string> unused_settings(const Scene& scene) {
  std::vector<std::string> unused;
  const auto add_unless_used = [&](const char* table, const auto& all, const Names& used, const char* why) {
    for (const auto& [name, value] : all) {
      if (!used.contains(name)) unused.push_back(fmt::format("{}.{}: without effect, as {}", table, name, why));
    }
  };
  add_unless_used("materials", scene.materials, materials_in_use(scene), "no block is of this material");
  add_unless_used("joints", scene.joints, joints_in_use(scene), "no joint is of this family");

  const BlockKinds kinds = kinds_of_blocks(scene);
  const SolverSettings none;
  const SolverSettings& usual = scene.quality.empty() ? none : quality_named(scene.quality).solver;
  const auto add_if = [&](bool is_unused, const std::string& key, const char* why) {
    if (is_unused) unused.push_back(fmt::format("{}: without effect, as {}", key, why));
  };
  // Whether a value is neither the quality's nor that without it.
  const auto is_given = [&](const auto& of) { return scene.solver.*of != usual.*of && scene.solver.*of != none.*of; };
  const char* const all_rigid = "no block deforms";
  add_if(!kinds.deformable && is_given(&SolverSettings::internal_forces), "solver.internal_forces", all_rigid);
  add_if(!kinds.deformable && is_given(&SolverSettings::deformation_inertia), "solver.deformation_inertia", all_rigid);
  add_if(!kinds.deformable && is_given(&SolverSettings::unit_inertia), "solver.unit_inertia", all_rigid);
  const char* const none_rigid = "no block is rigid";
  add_if(!kinds.rigid && scene.blocks && scene.blocks->contact.point_spacing > 0.0, "contact.point_spacing",
         none_rigid);
  add_if(!kinds.rigid && scene.cubic_points, "contact.cubic_points", none_rigid);
  const bool settles = std::ranges::any_of(
      scene.stages, [](const Stage& stage) { return stage.equilibrium_ratio.has_value() || stage.solver; });
  const auto& settling = scene.solver.settling_damping;
  add_if(!settles && settling && *settling != usual.settling_damping.value_or(-1.0), "solver.settling_damping",
         "no stage ends by equilibrium_ratio");

  add_unused_of_wall(scene, add_if);
  for (std::size_t i = 0; i < scene.damage.size() && !has_parted_units(scene); ++i)
    add_if(scene.damage[i].through_units, fmt::format("damage.{}.through_units", i + 1), "no unit has a joint in it");
  if (scene.members) add_unused_of_members(scene, *scene.members, add_if);

  const RandomSample first;
  const bool is_random = std::ranges::any_of(scene.joints, [](const auto& joint) { return joint.second.is_random(); });
  const bool at_means = scene.random.sample == 0;  // as an ensemble has its first wall
  add_if(!is_random && !at_means && (scene.random.seed != first.seed || scene.random.sample != first.sample),
         "[random]", "no property of a joint has a distribution, and no joint missing_mortar");
  return unused;
}

}  // namespace quoin
