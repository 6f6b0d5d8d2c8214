// Blocks as they are at the start: numbers of their items, shapes, zones, masses.
#pragma once

#include <utility>
#include <vector>

#include "geometry/zoning.h"
#include "model/model_block.h"
#include "scene/blocks.h"

namespace quoin::blocks {

struct World;

// What every process has: how many gridpoints, zones and corners each block has, where they begin, how blocks go
// together.
void number_blocks(World& w);
void lay_out(World& w, int block);

// Mass of a rigid block, in the coordinates of its shape, without mass scaling.
struct RigidMass {
  double mass;            // kg
  Vector centre;          // m
  geometry::Eigen3 axes;  // principal inertia, kg m2
};
RigidMass rigid_mass(const World& w, const Block& block);
double density_of(const World& w, const Block& block);  // with the mass that is spread, kg/m3
geometry::Zoning make_zoning(const World& w, int block);
Pose pose(const World& w, int block);  // current place and orientation
// Gridpoints and their weights.
std::vector<std::pair<int32_t, double>> shares_at(const World& w, int block, const Vector& point);

}  // namespace quoin::blocks
