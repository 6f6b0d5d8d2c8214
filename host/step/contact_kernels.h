// Contact points of deformable blocks, eight in a SIMD group: on triangles of two of them, and on gridpoints, pair by
// pair. Compiled for every instruction set of Highway and chosen at run time.
//
// On triangles:
// Block a owns the plane of a triangle, n its normal, s along its first edge. The point lies on a triangle of block b.
// The foot of the point on a's triangle follows it, so the pair of forces stays collinear. Both forces act at the
// point. Shear times the gap is then a couple, which a's triangle carries as forces along n.
//
// On gridpoints:
// The axes e_k = R_a E_k turn with the frame of block a (deformable_kernels.h). d is the vector from the gridpoint of a
// to that of b. On a rigid block b it leads to the place x_b + R_b arm of the point. The opening is e_n . d less the
// reference; slip increments are the changes of e_s . d and e_t . d in a step. The force f = A (sigma e_n + tau_s e_s +
// tau_t e_t) acts at both ends of d. R_a is a function of the corners of a. So the work of f on changes of d in turning
// axes also needs the moment d x f on the frame of a. With it forces, moments and energy balance to rounding at any
// slip.
#pragma once

#include <span>

#include "model/block_frames.h"
#include "model/chunks.h"
#include "model/rigid_bodies.h"
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

// Columns of a family, beginning at its first point, and the gridpoints of a chunk.
struct GridpointColumns : PointColumns {
  const std::int32_t *node_a, *node_b;  // gridpoints of the points from `first` on
  std::uint32_t first;
};

// Current places of blocks.
struct BlockPlaces {
  const BlockFrame* frames;  // by block; null: axes of points stay as at the start (small displacements)
  const Vector* node_x;      // m
  const Body* bodies;
};

// Computes openings and slip increments of the step.
void gridpoint_jumps(std::span<const GridpointPair> pairs, PairAxes* axes, const BlockPlaces& places,
                     const GridpointColumns& columns);

// Writes the forces on block a into the rows of the points. The rows of sums get the moments on its frame and the
// resultants on a rigid block b. Where axes stay as at the start there are no moments on frames.
void gridpoint_forces(std::span<const GridpointPair> pairs, const PairAxes* axes, const BlockPlaces& places,
                      const GridpointColumns& columns, FacetRow* rows);

}  // namespace quoin::blocks
