// Generators: what a scene describes in a few numbers, block by block and joint by joint.
#pragma once

#include <map>
#include <string>

#include "scene/assembly.h"
#include "scene/scene.h"

namespace quoin {

// The order of blocks: courses from the bottom, each from the left; then the rigid beams.
Assembly generate_wall(const WallSpec& wall, const std::map<std::string, BlockMaterial>& materials,
                       const std::map<std::string, JointFamily>& joints);

Assembly generate_building(const BuildingSpec& building, const std::map<std::string, BlockMaterial>& materials,
                           const std::map<std::string, JointFamily>& joints);

// Assembly of the scene's wall or building.
Assembly assemble(const Scene& scene);

// Gross area of a bed joint, m2, over the whole thickness.
double bed_area(const WallSpec& wall);
// The same of all walls of a building and their corners.
double bed_area(const BuildingSpec& building);
// The same of a scene that is a wall or building alone; 0 of any other.
double bed_area(const Scene& scene);

}  // namespace quoin
