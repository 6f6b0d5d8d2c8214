// Contact points on triangles of two deformable blocks, eight in a SIMD group. Compiled for every instruction set of
// Highway and chosen at run time.
//
// Block a owns the plane of a triangle, n its normal, s along its first edge. The point lies on a triangle of block b.
// The foot of the point on a's triangle follows it, so the pair of forces stays collinear. Both forces act at the
// point. Shear times the gap is then a couple, which a's triangle carries as forces along n.
#pragma once

#include <span>

#include "model/sides.h"
#include "step/point_kernels.h"

namespace quoin::blocks {

// Columns are those of a family, beginning at its first point. Computes openings and slip increments of the step, and
// the frames of these triangles. fixed: frames and feet stay as at the start (small displacements).
void facet_jumps(std::span<FacetLanes> lanes, FacetFrames* frames, const Vector* node_x, const PointColumns& columns,
                 bool fixed);

// Writes the forces of points on gridpoints into their rows, from the tractions and frames of facet_jumps.
void facet_forces(std::span<const FacetLanes> lanes, const FacetFrames* frames, const PointColumns& columns,
                  FacetRow* rows);

// Sides of contact points on one block.
struct FacetTouches {
  std::span<const OwnerTouch> owner;
  std::span<const CarrierTouch> carrier;
  std::span<const GridpointTouch> gridpoint;        // gridpoints of block b
  std::span<const GridpointTouch> owner_gridpoint;  // gridpoints of block a, with one row a point
};

// Adds the forces of these points to the block's gridpoints, four doubles each. Returns their sum, N.
Vector add_facet_rows(const FacetTouches& touches, const FacetRow* rows, double* force);

}  // namespace quoin::blocks
