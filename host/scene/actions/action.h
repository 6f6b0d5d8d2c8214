// Actions on blocks in a stage of any scene: each has a file in this folder, and a row below. Its effect in a step is
// in a file of step/actions.
#pragma once

#include <string>
#include <vector>

#include "base/registry.h"
#include "scene/blocks.h"
#include "scene/reader.h"

namespace quoin {

struct StageAction {
  const char* key;  // key in the table of a stage
  const char* has;  // the key in messages: "has pressures on faces"
  void (*read)(reader::Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names);
  bool (*acts)(const Stage& stage);
  std::string (*text)(const Stage& stage);  // all numbers of the action on which the bits of a run depend
  // Throws Error(bad_input) where the action would do nothing on these blocks, or not what it says. Null: none does.
  void (*check)(const Stage& stage, const blocks::Assembly& blocks) = nullptr;
};

QUOIN_REGISTRY(StageAction, kStageActions, kGroundMotion, kCollapseLoad, kMovingLoad, kPointForces, kFacePressures);

// Throws Error(bad_input) for a load on a fixed block.
void refuse_on_fixed(const blocks::Block& block, const char* load, const Source& source);
// Throws where a load acts along components of the block whose velocity the stage prescribes, with its rotation held.
void refuse_on_driven(const blocks::Block& block, const Vec3& along, const char* load, const Stage& stage);

// Reads the block of an action. names: those of the scene; empty: the name is checked later.
inline void read_block_name(reader::Table& t, std::string& block, const std::vector<std::string>& names) {
  if (names.empty())
    t.text("block", block, "the name of a block", true);
  else
    t.choice("block", block, names, true);
}

}  // namespace quoin
