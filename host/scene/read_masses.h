// Mass of blocks in addition to that of their volume.
#pragma once

#include "scene/blocks.h"
#include "scene/reader.h"

namespace quoin {

std::vector<AddedMass> read_masses(reader::Table& scene);

// Masses of floors, distributed over their beams.
std::vector<AddedMass> masses_of_floors(const BuildingSpec& building);

// Adds the masses of the scene to its blocks. Throws Error(bad_input) for names without a block, points outside of
// deformable blocks, and points of several blocks.
void add_masses(const Scene& scene, blocks::Assembly* assembly);

}  // namespace quoin
