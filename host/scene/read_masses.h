// Mass that blocks have besides that of their volume.
#pragma once

#include "scene/blocks.h"
#include "scene/reader.h"

namespace quoin {

std::vector<AddedMass> read_masses(reader::Table& scene);

// Those of floors, shared by their beams.
std::vector<AddedMass> masses_of_floors(const BuildingSpec& building);

// Gives the masses of the scene to blocks. Error(bad_input): names that no block has, points outside of blocks that
// deform, points for several blocks.
void add_masses(const Scene& scene, blocks::Assembly* assembly);

}  // namespace quoin
