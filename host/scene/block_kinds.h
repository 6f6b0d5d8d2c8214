// Whether blocks of a scene are rigid, and whether some deform.
#pragma once

#include <algorithm>
#include <string>

#include "scene/scene.h"

namespace quoin {

struct BlockKinds {
  // Some are. Rigid beams of walls and buildings do not count. A fixed block does not deform unless a stage controls
  // it.
  bool deformable = false, rigid = false;
};

inline BlockKinds kinds_of_blocks(const Scene& scene) {
  BlockKinds kinds;
  const auto add = [&](bool rigid) { (rigid ? kinds.rigid : kinds.deformable) = true; };
  if (scene.wall) add(scene.wall->rigid_units);
  if (scene.building) add(false);
  if (!scene.blocks) return kinds;
  const auto is_controlled = [&](const std::string& name) {
    return std::ranges::any_of(scene.stages, [&](const Stage& stage) {
      return std::ranges::find(stage.controls, name, &BodyControl::body) != stage.controls.end();
    });
  };
  for (const BlockSpec& block : scene.blocks->blocks) {
    if (!block.fixed || block.rigid || is_controlled(block.name)) add(block.rigid);
  }
  for (const DryWallSpec& wall : scene.blocks->walls) add(wall.rigid);
  for (const ArchSpec& arch : scene.blocks->arches) add(arch.rigid);
  return kinds;
}

}  // namespace quoin
