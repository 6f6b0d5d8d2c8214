// Blocks from surfaces as other programs draw them. They are closed, but no plane fits their faces exactly. Corners are
// written several times, and faces run either way round.
#pragma once

#include <vector>

#include "geometry/polyhedron.h"
#include "geometry/raw_shape.h"

namespace quoin::geometry {

// How far a drawn surface may lie off the planes of the block that is made of it, relative to the block's largest
// extent. A joint's normal is then off by 0.3 degrees at most, and friction by half a per cent.
constexpr double warp_bound = 5e-3;

// Corners at one place made one; faces without area, and those that are there twice, left out.
void weld(RawShape& shape);

// Connected surfaces (by edges), in the order of their first faces.
std::vector<RawShape> split(const RawShape& shape);

// Every edge has two faces.
bool is_closed(const RawShape& shape);

// Turns faces so that all run counter-clockwise seen from outside, where every edge has two of them.
void orient(RawShape& shape);

// All corners in one plane, within warp_bound of their extent.
bool is_flat(const RawShape& shape);

struct DrawnShape {
  ConvexPolyhedron shape;
  double warp = 0.0;  // m, from the drawn corners and surface to the block at most; 0: as drawn
};

// The block of a welded and oriented surface. Faces warped by less than warp_bound get the plane that fits their
// corners best, and corners move to where the planes meet. Two blocks that share the corners of a face share its plane.
// A joint then has one face, and not two triangles at an angle. Throws Error(bad_input) as from_faces, and for surfaces
// beyond the bound.
DrawnShape from_drawn(const RawShape& shape);

// A plate behind a flat face, a tenth of the extent of the face's hull thick. It lies away from `others`, the middle of
// the blocks before it. Throws Error(bad_input) for a face that is not convex.
ConvexPolyhedron plate(const RawShape& shape, const Vector& others);

}  // namespace quoin::geometry
