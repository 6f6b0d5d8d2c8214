#include "blocks/from_bricks.h"

#include <map>
#include <utility>

namespace quoin::blocks {

namespace {

// Above this, motion that drifts is driven by eq. 1 in one of its own periods (scene/quality.cpp).
constexpr double kLargestFraction = 0.6;

// Of the least extent of a brick: below the size of a zone, so that points still face the triangles they belong to.
constexpr double kJointMotion = 0.05;

}  // namespace

Assembly from_bricks(const quoin::Assembly& bricks) {
  Assembly assembly;
  assembly.shared_names = true;
  assembly.symmetry_plane_z0 = bricks.symmetry_plane_z0;
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

SolverSettings for_large_motion(const SolverSettings& given) {
  SolverSettings solver = given;
  if (solver.damping == DampingKind::block) {
    const SolverSettings eq1;
    solver.damping = eq1.damping;
    solver.local_damping = eq1.local_damping;
    solver.settling_damping.reset();
    solver.time_step_fraction = std::min(solver.time_step_fraction, kLargestFraction);
  }
  solver.deformation_inertia = solver.unit_inertia = 1.0;
  return solver;
}

}  // namespace quoin::blocks
