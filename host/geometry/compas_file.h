// Assemblies of COMPAS as its JSON has them: compas_assembly (Assembly, of COMPAS 1 and 2), compas_dem (BlockModel),
// and bare meshes.
#pragma once

#include <string>
#include <vector>

#include "geometry/raw_shape.h"

namespace quoin::geometry {

// Every mesh that is a block, in the order of the file, where its transformation puts it, with is_support. Meshes of
// interfaces are none. Throws Error(bad_input) with file and place in it: no JSON, vertices without coordinates, faces
// of vertices that are not there.
std::vector<RawShape> read_compas(const std::string& path, const std::string& bytes);

}  // namespace quoin::geometry
