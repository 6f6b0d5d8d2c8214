// Blocks from mesh files: OFF, OBJ, STL (ASCII and binary) and assemblies of COMPAS (JSON), distinguished by the file
// name's ending.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "geometry/polyhedron.h"

namespace quoin::geometry {

struct NamedShape {
  std::string name;
  ConvexPolyhedron shape;
  bool support = false;  // fixed block: is_support of COMPAS, or fixed by the caller
  double warp = 0.0;     // largest distance of drawn faces from the block's planes, m; 0: as drawn
  bool plate = false;    // whether it is a support drawn as a flat face, to which a thickness was added
};

// One block per body, a closed surface of an object. An object is "o" or "g" of OBJ, "solid" of STL, a block of an
// assembly, or an OFF file. An object of several bodies gives NAME/0, NAME/1 ... Blocks with the same name get their
// number in the file, NAME#7, or else their place. Blocks without a name get the file's name and their place. scale:
// factor that converts lengths to m. Faces may have either orientation, and may be warped within warp_bound
// (drawn_shape.h). fixed: whether the block of a name is a support. A support may be one flat face; it becomes a plate
// behind it. Throws Error(bad_input) with file and line for malformed text, and with the blocks for shapes that are not
// convex and closed.
std::vector<NamedShape> read_mesh_file(const std::string& path, double scale = 1.0,
                                       const std::function<bool(const std::string& name)>& fixed = {});

// The blocks as OBJ text, for other programs.
std::string to_obj(const std::vector<NamedShape>& shapes);

}  // namespace quoin::geometry
