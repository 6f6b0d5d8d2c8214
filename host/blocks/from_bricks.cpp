#include "blocks/from_bricks.h"

#include <fmt/core.h>

#include <map>
#include <set>
#include <utility>

#include "scene/error.h"

namespace quoin::blocks {

namespace {

// Of the least extent of a brick: below the size of a zone, so that points still face the triangles they belong to.
constexpr double kJointMotion = 0.05;

[[noreturn]] void refuse(const Scene& scene, const std::string& why) {
  throw Error(Exit::bad_input, fmt::format("{}: solver.large_motion = \"always\": {}", scene.file, why));
}

void check(const quoin::Assembly& bricks, const Scene& scene) {
  if (bricks.symmetry_plane_z0)
    refuse(scene, "half of the thickness cannot leave its plane of symmetry; set wall.half_thickness = false");
  if (scene.solver.critical_time_step == CriticalTimeStep::nodal)
    refuse(scene, "critical_time_step = \"nodal\" is for small displacements only; take \"assembled\"");
  std::set<std::string> names;
  for (const Brick& brick : bricks.bricks) {
    if (brick.body.empty()) continue;
    if (!brick.rigid) refuse(scene, fmt::format("'{}' is a deformable block with loads; make it rigid", brick.body));
    if (!names.insert(brick.body).second)
      refuse(scene, fmt::format("'{}' names several rigid blocks; only beams can be moved so far", brick.body));
  }
  for (const Stage& stage : scene.stages) {
    if (stage.whiffletree)
      refuse(scene, fmt::format("stage '{}' pushes floors through a whiffletree, which only small displacements have",
                                stage.name));
    if (!stage.law_swaps.empty())
      refuse(scene, fmt::format("stage '{}' replaces laws, which only small displacements have", stage.name));
  }
}

}  // namespace

Assembly from_bricks(const quoin::Assembly& bricks, const Scene& scene) {
  check(bricks, scene);
  Assembly assembly;
  assembly.materials = bricks.materials;
  assembly.families = bricks.families;
  std::map<std::array<double, 3>, int> shape_of_size;
  for (const Brick& brick : bricks.bricks) {
    Block block;
    block.name = brick.body;
    block.material = brick.material;
    block.position = geometry::vector(brick.origin);
    block.rigid = brick.rigid;
    block.unit = brick.unit, block.course = brick.course;
    if (!brick.rigid) {
      block.divisions = brick.zones;
      block.parity = 1 - brick.parity % 2;  // the lattice's pattern 0 is the other one here
    }
    const auto [shape, is_new] = shape_of_size.try_emplace(brick.size, static_cast<int>(assembly.shapes.size()));
    if (is_new) assembly.shapes.push_back(geometry::box({}, geometry::vector(brick.size)));
    block.shape = shape->second;
    assembly.blocks.push_back(std::move(block));
  }
  std::map<std::pair<int, int>, int> family;
  int others = -1;
  for (const Joint& joint : bricks.joints) {
    family[std::minmax(joint.block_a, joint.block_b)] = joint.family;
    if (others < 0 && joint.face_a / 2 == 1) others = joint.family;
  }
  others = std::max(others, 0);
  assembly.family_of = [family = std::move(family), others](const Meeting& meeting) {
    const auto found = family.find(std::minmax(meeting.block_a, meeting.block_b));
    return found == family.end() ? others : found->second;
  };
  assembly.contact.small_displacement = 0.0;
  assembly.contact.joint_motion = kJointMotion;
  return assembly;
}

}  // namespace quoin::blocks
