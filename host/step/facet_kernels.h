// Contact points on triangles of two deformable blocks, eight side by side. Compiled for every instruction set of
// Highway and chosen at run time.
//
// Block a owns the plane of a triangle, n its normal, s along its first edge. b carries the point on a triangle of its
// own. The foot of the point on a's triangle follows it, so that the pair of forces stays collinear. The pair acts at
// the point: shear times the gap is a couple, which a's triangle takes as forces along n.
#pragma once

#include <span>

#include "model/sides.h"

namespace quoin::blocks {

// Columns of a family, from its first point on.
struct FacetColumns {
  const double *traction[3], *viscous[3];  // Pa; viscous[0] null: none
  double *slid[2], *normal_jump, *slip[2];
};

// Openings and slips of the step, and the frames that they are in. fixed: these and feet stay those of the start (small
// displacements).
void facet_jumps(std::span<FacetLanes> lanes, FacetFrames* frames, const Vector* node_x, const FacetColumns& columns,
                 bool fixed);

// Forces on gridpoints from the tractions at the jumps of facet_jumps, in its frames, into the rows of the points.
void facet_forces(std::span<const FacetLanes> lanes, const FacetFrames* frames, const FacetColumns& columns,
                  FacetRow* rows);

// The sides of points that belong to one block.
struct FacetTouches {
  std::span<const OwnerTouch> owner;
  std::span<const CarrierTouch> carrier;
  std::span<const GridpointTouch> gridpoint;        // gridpoints of block b
  std::span<const GridpointTouch> owner_gridpoint;  // gridpoints of block a, with one row a point
};

// Adds what acts on the block to its gridpoints, four doubles each; returns the sum, N.
Vector add_facet_rows(const FacetTouches& touches, const FacetRow* rows, double* force);

}  // namespace quoin::blocks
