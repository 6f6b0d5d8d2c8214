// Actions on blocks in a stage of any scene: forces, pressures, ground motion, collapse.
#pragma once

#include <string>
#include <vector>

#include "scene/blocks.h"
#include "scene/reader.h"

namespace quoin {

// Whether the table of a stage has any action.
bool has_actions(const reader::Table& t);

// Reads the actions of a stage. folder: that of files named by the scene, with its slash. names: allowed names of
// blocks; empty: names are checked later.
void read_actions(reader::Table& t, Stage& stage, const std::string& folder, const std::vector<std::string>& names);

// Throws Error(bad_input) where velocities or actions of a stage would do nothing, or not what they say.
void check_stages(const Scene& scene, const blocks::Assembly& blocks);

// Reason for which a run on the lattice leaves it at the begin of a stage, as messages have it; empty: none.
std::string leaves_lattice(const Scene& scene, std::size_t stage);

}  // namespace quoin
