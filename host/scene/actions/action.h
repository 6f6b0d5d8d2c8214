// What acts on blocks from outside in a stage of any scene: one file each of this folder, and its name below. What it
// does in a step has a file of step/actions.
#pragma once

#include <string>
#include <vector>

#include "base/registry.h"
#include "scene/reader.h"

namespace quoin {

struct StageAction {
  const char* key;  // of the table of a stage
  const char* has;  // the same of a stage, in the words of messages: "has pressures on faces"
  void (*read)(reader::Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names);
  bool (*acts)(const Stage& stage);
  std::string (*text)(const Stage& stage);  // where it acts: all numbers on which the bits of a run depend
};

QUOIN_REGISTRY(StageAction, kStageActions, kGroundMotion, kCollapseLoad, kMovingLoad, kPointForces, kFacePressures);

// The block that something acts on. names: those that the scene has; empty: they are looked up later.
inline void read_block_name(reader::Table& t, std::string& block, const std::vector<std::string>& names) {
  if (names.empty())
    t.text("block", block, "the name of a block", true);
  else
    t.choice("block", block, names, true);
}

}  // namespace quoin
