// What acts on blocks from outside in a stage of any scene: forces, pressures, ground motion, collapse.
#pragma once

#include <string>
#include <vector>

#include "scene/reader.h"

namespace quoin {

// Whether the table of a stage has any of them.
bool has_actions(const reader::Table& t);

// folder: of the files that the scene names, with its slash. names: of the blocks that can be named; empty: names are
// resolved later.
void read_actions(reader::Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names);

}  // namespace quoin
