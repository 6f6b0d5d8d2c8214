// Blocks from surfaces of drawing programs. Such surfaces are closed, but faces are not exactly planar, corners are
// repeated, and faces have either orientation.
#pragma once

#include <vector>

#include "geometry/polyhedron.h"
#include "geometry/raw_shape.h"

namespace quoin::geometry {

// Largest distance of a drawn surface from the planes of its block, relative to the block's largest extent. The error
// of a joint's normal is then at most 0.3 degrees, and that of friction half a per cent.
constexpr double warp_bound = 5e-3;

// Merges corners at one place; removes faces without area, and repeated faces.
void weld(RawShape& shape);

// Connected surfaces (by edges), in the order of their first faces.
std::vector<RawShape> split(const RawShape& shape);

// Whether every edge has two faces.
bool is_closed(const RawShape& shape);

// Orients faces counter-clockwise seen from outside, where every edge has two of them.
void orient(RawShape& shape);

// Whether all corners are in one plane, within warp_bound of their extent, and enclose no volume: a thin closed block
// is not flat.
bool is_flat(const RawShape& shape);

struct DrawnShape {
  ConvexPolyhedron shape;
  double warp = 0.0;  // largest distance of drawn corners and surface from the block, m; 0: as drawn
};

// The block of a welded and oriented surface. Faces warped by less than warp_bound get the best-fit plane of their
// corners, and corners move to the intersection of planes. Two blocks that share the corners of a face share its plane.
// A joint then has one face, and not two triangles at an angle. Throws Error(bad_input) as from_faces, and for surfaces
// beyond the bound.
DrawnShape from_drawn(const RawShape& shape);

// Unites neighbouring faces whose corners lie within `tolerance` (m) of one plane, at most warp_bound of the extent,
// and moves corners to where planes meet. Rounded coordinates so keep faces whole. Returns how far corners have moved,
// m; 0: nothing to unite. Less than 0: faces cannot be united, and the shape is as before.
double unite_faces(ConvexPolyhedron& shape, double tolerance);

// A plate behind a flat face, with a thickness of a tenth of the extent of the face's hull. It is on the side away from
// `others`, the mean corner of the other blocks. Throws Error(bad_input) for a face that is not convex.
ConvexPolyhedron plate(const RawShape& shape, const Vector& others);

}  // namespace quoin::geometry
