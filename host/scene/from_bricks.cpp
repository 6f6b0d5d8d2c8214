#include "scene/from_bricks.h"

#include <algorithm>

namespace quoin::blocks {

FamilyOfBricks::FamilyOfBricks(const quoin::Assembly& bricks) {
  const auto is_beam = [&](int brick) { return bricks.bricks[static_cast<std::size_t>(brick)].beam; };
  const auto is_bed = [](const Joint& joint) { return joint.face_a / 2 == 1; };
  auto bed = std::ranges::find_if(bricks.joints, [&](const Joint& joint) {
    return is_bed(joint) && !is_beam(joint.block_a) && !is_beam(joint.block_b);
  });
  if (bed == bricks.joints.end()) bed = std::ranges::find_if(bricks.joints, is_bed);
  if (bed != bricks.joints.end()) others_ = bed->family;
  for (const Joint& joint : bricks.joints) joined_[std::minmax(joint.block_a, joint.block_b)] = joint.family;
  for (const auto& [a, b] : bricks.apart) joined_[std::minmax(a, b)] = kNoFamily;
}

int FamilyOfBricks::operator()(int brick_a, int brick_b) const {
  const auto found = joined_.find(std::minmax(brick_a, brick_b));
  return found == joined_.end() ? others_ : found->second;
}

void add_bricks(const quoin::Assembly& bricks, Assembly* assembly) {
  std::map<std::array<double, 3>, int> shape_of_size;
  for (const Brick& brick : bricks.bricks) {
    Block block;
    block.name = brick.name.empty() ? brick.body : brick.name;
    block.body = brick.body;
    block.material = brick.material;
    block.position = geometry::vector(brick.origin);
    block.rigid = brick.rigid;
    block.fixed = brick.fixed;
    if (brick.load_height) {
      block.centre = block.position + 0.5 * geometry::vector(brick.size);
      block.centre->y = *brick.load_height;
    }
    block.unit = brick.unit, block.course = brick.course, block.beam = brick.beam;
    if (!brick.rigid) {
      block.divisions = brick.zones;
      block.parity = 1 - brick.parity % 2;  // pattern 0 of the lattice is pattern 1 of blocks of any shape
    }
    const auto [shape, is_new] = shape_of_size.try_emplace(brick.size, static_cast<int>(assembly->shapes.size()));
    if (is_new) assembly->shapes.push_back(geometry::box({}, geometry::vector(brick.size)));
    block.shape = shape->second;
    assembly->blocks.push_back(std::move(block));
  }
}

Assembly from_bricks(const quoin::Assembly& bricks) {
  Assembly assembly;
  assembly.shared_names = true;
  assembly.symmetry_plane_z0 = bricks.symmetry_plane_z0;
  assembly.materials = bricks.materials;
  assembly.families = bricks.families;
  add_bricks(bricks, &assembly);
  assembly.family_of = [family = FamilyOfBricks(bricks)](const Meeting& meeting) {
    return family(meeting.block_a, meeting.block_b);
  };
  assembly.contact.small_displacement = 0.0;
  assembly.contact.joint_motion = kJointMotion;
  return assembly;
}

}  // namespace quoin::blocks
