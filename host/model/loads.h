// Loads, pressures and weight on blocks.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "geometry/vector.h"

namespace quoin::blocks {

using geometry::Vector;

struct Load {
  int block;
  Vector point;                                   // place of the point at the start, m; moves with the block
  Vector force;                                   // N, direction fixed in space
  std::vector<std::pair<int32_t, double>> share;  // deformable: nodes and weights
  Vector arm;                                     // rigid: place in the body frame, m
  double scale = 1.0;                             // factor of the stage's ramp
};

struct Pressure {
  int block, face;
  double value;                                   // Pa, > 0 pushes on the block; follows the face
  std::vector<std::array<int32_t, 3>> triangles;  // deformable
  Vector arm, push;                               // rigid: centroid, m, and -normal * area, m2, in the body frame
  double scale = 1.0;
};

struct Wrench {
  Vector force, torque;  // N; about the centre of mass, N m
};

// Actions on blocks; stages set them between steps.
struct Actions {
  std::vector<Load> loads;
  std::vector<Pressure> pressures;
  std::vector<uint8_t> loaded;     // by block: some load or pressure acts on it
  std::vector<Wrench> applied;     // by block, directions fixed in space; empty: none
  Vector gravity;                  // with the body force of a collapse stage, m/s2
  Vector of_collapse;              // that body force by mass, m/s2
  Vector ground_then, ground_now;  // velocity of the ground half a step ago and now, m/s
};

}  // namespace quoin::blocks
