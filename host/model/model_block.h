// Blocks of a model: indices of their items in its arrays, and properties of their shapes.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "geometry/polyhedron.h"
#include "geometry/vector.h"
#include "geometry/zoning.h"
#include "model/lanes.h"

namespace quoin::blocks {

using geometry::Matrix;
using geometry::Vector;

struct ModelBlock {
  const geometry::ConvexPolyhedron* shape;  // topology; body-frame vertices of a rigid block are in BlockShapes::corner
  int32_t body = -1;                        // rigid: index into bodies
  int32_t first_node = 0, node_count = 0;   // deformable
  int32_t zone_count = 0;
  int32_t first_lanes = 0, lanes_count = 0;  // its zones: indices into Zones::lanes
  int32_t congruent = -1;                    // index into Zones::congruent; -1: the block shares no stiffness
  uint32_t first_corner = 0;                 // index into BlockShapes::corner: vertices of the shape
  uint32_t first_normal = 0;
  double mass = 0.0;    // mass for weight, kg
  Vector load_arm;      // rigid: from the centre of mass to that without point masses, where loads act; in body axes, m
  double radius = 0.0;  // largest distance of a vertex from the centre, m
  double least_extent = 0.0;                               // m
  double corner_area = 0.0;                                // nominal area of an edge or corner contact, m2
  std::vector<geometry::Zoning::SurfaceTriangle> surface;  // deformable; node numbers of the model
};

struct Pose {
  Vector x;
  Matrix r;
};

// Data of one shape of the scene.
struct ShapeFacts {
  geometry::MassProperties mass;
  geometry::Eigen3 axes;
  double least_extent, area;  // m, m2 of the surface
};

// Data of shapes, and corners and faces of blocks.
struct BlockShapes {
  std::vector<ShapeFacts> facts;
  // Cache of a few zonings (block_layout.cpp).
  std::map<std::array<double, 6>, std::shared_ptr<const geometry::Zoning>> zonings;
  LaneVector<Vector> corner, normal;                // of rigid blocks in the body frame: corners, m, and face normals
  LaneVector<Vector> placed_corner, placed_normal;  // of all blocks at the last detection
};

// Poses of all blocks.
struct Poses {
  LaneVector<Pose> start, broad;  // at the start, and at the last broad phase
};

}  // namespace quoin::blocks
