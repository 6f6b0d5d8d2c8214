// Blocks from mesh files: OFF, OBJ, STL (ASCII and binary) and assemblies of COMPAS (JSON), told apart by the file
// name's ending.
#pragma once

#include <string>
#include <vector>

#include "geometry/polyhedron.h"

namespace quoin::geometry {

struct NamedShape {
  std::string name;
  ConvexPolyhedron shape;
  bool support = false;  // of COMPAS: does not move
};

// One block an object ("o" or "g" of OBJ, "solid" of STL, a block of an assembly; an OFF file is one object). Lengths
// are multiplied by `scale` to give m. Throws Error(bad_input) with file and line for text it cannot read, and as
// from_faces for shapes that are not convex and closed.
std::vector<NamedShape> read_mesh_file(const std::string& path, double scale = 1.0);

// The blocks as OFF text (one object) or OBJ text, for other programs.
std::string to_obj(const std::vector<NamedShape>& shapes);

}  // namespace quoin::geometry
