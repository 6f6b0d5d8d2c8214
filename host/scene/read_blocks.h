// Tables of scenes of blocks of any shape, and of their stages; host/scenes/BLOCKS.md lists the keys.
#pragma once

#include <string>

#include "scene/reader.h"

namespace quoin {

// folder: that of files named by the scene, with its slash. Faults go to the context of the table.
BlocksSpec read_blocks(reader::Table& t, const Scene& scene, const std::string& folder);
// Keys of [contact] for blocks of any shape.
void read_contact(reader::Table& c, const SolverSettings& solver, BlocksSpec::Contact* contact);
Stage read_block_stage(reader::Table t, const Scene& scene, const Stage* previous, const std::string& folder);

}  // namespace quoin
