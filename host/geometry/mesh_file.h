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
  bool support = false;  // does not move: is_support of COMPAS, or fixed by the caller
  double warp = 0.0;     // m, how far faces that no plane fits were drawn off the block's; 0: as drawn
  bool plate = false;    // a support that is drawn as a flat face, with a thickness behind it
};

// One block a body: a closed surface of an object. An object is "o" or "g" of OBJ, "solid" of STL, a block of an
// assembly, or an OFF file. An object of several bodies gives NAME/0, NAME/1 ...; blocks that share a name get the
// file's number for each, NAME#7, or their place. Those without one that of the file and their place. Lengths are
// multiplied by `scale` to give m. Which way round faces run is no matter, and faces may be warped within warp_bound
// (drawn_shape.h). fixed: whether the block of a name is a support. A support may be one flat face, and is a plate
// behind it. Throws Error(bad_input) with file and line for text it cannot read, and with the blocks for shapes that
// are not convex and closed.
std::vector<NamedShape> read_mesh_file(const std::string& path, double scale = 1.0,
                                       const std::function<bool(const std::string& name)>& fixed = {});

// The blocks as OFF text (one object) or OBJ text, for other programs.
std::string to_obj(const std::vector<NamedShape>& shapes);

}  // namespace quoin::geometry
