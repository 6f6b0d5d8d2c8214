// Places where external loads act on blocks.
#pragma once

#include <string>
#include <vector>

#include "scene/blocks.h"
#include "scene/scene.h"

namespace quoin::blocks {

struct LoadPlace {
  int block = -1;
  geometry::Vector position, at;  // position on the line of the load, and place on the block, at the start, m
};

// Place for each position of the load: on the first face on the force's line of action, or in the block that contains
// the position. Throws Error(bad_input), with the place in the scene, for a position without a block on its line of
// action.
std::vector<LoadPlace> places_of(const MovingLoad& load, const Assembly& assembly, const std::string& where);

// The block of this name that is nearest to a point at the start, m. Throws Error(bad_input): there is none of the
// name.
int block_at(const Assembly& assembly, const std::string& name, const geometry::Vector& point,
             const std::string& where);

// Face of a block whose outward normal is closest to this one. Throws Error(bad_input) where two are equally close.
int face_towards(const Assembly& assembly, int block, const geometry::Vector& normal, const std::string& where);

struct BlockFace {
  int block = -1, face = 0;
};

// Faces along an outward normal, of those blocks of this name that reach furthest along it. Of a course they are at its
// end, or all along its side. Throws Error(bad_input): there is none of the name.
std::vector<BlockFace> outer_faces(const Assembly& assembly, const std::string& name, const geometry::Vector& towards,
                                   const std::string& where);

// Centre of mass of a block at the start, without `masses`, m. The position of a block is the origin of its shape,
// which may be that of the scene.
geometry::Vector centre_of(const Assembly& assembly, int block);

// Distance of a point from a block at the start, m; not above 0 inside.
double distance_from(const Assembly& assembly, const Block& block, const geometry::Vector& point);

}  // namespace quoin::blocks
