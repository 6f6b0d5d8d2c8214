// Generators: from the few numbers of a scene to blocks and joints.
#pragma once

#include <iterator>
#include <map>
#include <string>

#include "scene/assembly.h"
#include "scene/scene.h"

namespace quoin {

// Index of a name in the order of a map that has it.
template <typename Map>
int index_of(const Map& map, const std::string& name) {
  return static_cast<int>(std::distance(map.begin(), map.find(name)));
}

// An assembly with these materials and families of joints, in the order of their maps.
template <typename Assembled>
Assembled with_materials(const std::map<std::string, BlockMaterial>& materials,
                         const std::map<std::string, JointFamily>& joints) {
  Assembled assembly;
  for (const auto& [name, material] : materials) assembly.materials.push_back(material);
  for (const auto& [name, family] : joints) assembly.families.push_back(family);
  return assembly;
}

// Blocks in the order of courses from the bottom, each from the left; then the rigid beams.
Assembly generate_wall(const WallSpec& wall, const std::map<std::string, BlockMaterial>& materials,
                       const std::map<std::string, JointFamily>& joints);

Assembly generate_building(const BuildingSpec& building, const std::map<std::string, BlockMaterial>& materials,
                           const std::map<std::string, JointFamily>& joints);

// Assembly of the scene's wall or building.
Assembly assemble(const Scene& scene);

// Whether the bottom beams of a wall or building, or else its bottom course, are the ground. They are where a stage
// acts on blocks, or has no control.
bool stands_on_ground(const Scene& scene);
// Whether a body of this name is of that ground, whatever acts.
bool is_ground(const Scene& scene, const std::string& body);
// Fixes the ground, in scenes that stand on it alone.
void stand_on_ground(const Scene& scene, Assembly& bricks);

// Whether two half units of a course are of one unit.
bool same_unit(const WallSpec& wall, int course, int half_unit, int other);

// Gross area of a bed joint, m2, over the whole thickness.
double bed_area(const WallSpec& wall);
// Gross area of the bed joint of all walls and corners of a building, m2.
double bed_area(const BuildingSpec& building);
// Gross area of the bed joint of a scene that is a wall or building alone, m2; 0 for other scenes.
double bed_area(const Scene& scene);

}  // namespace quoin
