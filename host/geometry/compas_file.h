// Assemblies of COMPAS in JSON: compas_assembly (Assembly, of COMPAS 1 and 2), compas_dem (BlockModel), and bare
// meshes.
#pragma once

#include <string>
#include <vector>

#include "geometry/raw_shape.h"

namespace quoin::geometry {

// Every mesh that is a block, in the order of the file, with its transformation applied, and is_support. Meshes of
// interfaces are skipped. Throws Error(bad_input) with file and place for invalid JSON, vertices without coordinates,
// and faces with unknown vertices.
std::vector<RawShape> read_compas(const std::string& path, const std::string& bytes);

}  // namespace quoin::geometry
