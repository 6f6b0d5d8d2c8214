// Blocks at the start: numbers of their items, shapes, zones, masses.
#pragma once

#include <utility>
#include <vector>

#include "geometry/zoning.h"
#include "model/model_block.h"
#include "scene/blocks.h"

namespace quoin::blocks {

struct World;

// Numbers the items of all blocks, on every rank: gridpoints, zones and corners, where they begin, and units.
void number_blocks(World& w);
void lay_out(World& w, int block);

// Mass of a rigid block in the coordinates of its shape, without mass scaling.
struct RigidMass {
  double mass;            // kg
  Vector centre;          // m
  Vector load_place;      // centre without the point masses, where loads act, m
  geometry::Eigen3 axes;  // principal inertia, kg m2
};
RigidMass rigid_mass(const World& w, const Block& block);
double density_of(const World& w, const Block& block);  // kg/m3, with the mass that is spread over the block
geometry::Zoning make_zoning(const World& w, int block);
Pose pose(const World& w, int block);  // current position and orientation
// Gridpoints around a point of a block, with their weights.
std::vector<std::pair<int32_t, double>> shares_at(const World& w, int block, const Vector& point);

}  // namespace quoin::blocks
