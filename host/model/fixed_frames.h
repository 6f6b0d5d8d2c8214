// Frames that stay those of the start, as on the lattice, and blocks that leave them.
//
// In a fixed frame R displacements are small. Forces are -R (K u - q x b), u = R^T (x - x_0), with 2 q the moment of
// contact points on the frame (deformable_kernels.h). Arms are those of the start. A block that turns by more than
// kFixedFrame, or solver.rotation_bound, gets a frame that follows it (block_frames.h), with all blocks of its piece.
// The rigid part of its displacement then becomes a rotation,
//   x_0 + mean + theta x r + d  ->  c + mean + R(theta) (r + d),   r from the mass centre c,
// where d has neither momentum nor angular momentum. So strains, openings, slip and the momentum stay, and no energy is
// gained or lost but that of d turned by theta. Members at its gridpoints move by theta^2/2 r. Limit: theta = 0 changes
// nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vector.h"

namespace quoin::blocks {

struct World;

// Rotation from which on a frame follows its block, rad. A fixed frame mistakes a rotation theta for a strain
// theta^2/2: 1.3e-5 at this bound, a seventh of what the lattice allows (0.013 rad). Axes of its contact points are off
// by theta.
inline constexpr double kFixedFrame = 5e-3;
double largest_fixed_rotation(const World& w);  // that, or solver.rotation_bound where it is less

// Rigid part of a vector field on gridpoints: the mean + turn x (X - centre) whose difference from the field has
// neither momentum nor angular momentum. With a plane of symmetry z = 0, the part that keeps points on the plane.
struct RigidPart {
  geometry::Vector centre, mean, turn;
  geometry::Matrix inertia;  // sum m (r^2 1 - r r^T), kg m2
};
RigidPart rigid_part(std::span<const geometry::Vector> place, std::span<const double> mass,
                     std::span<const geometry::Vector> of, bool symmetry_plane);

// Turns the gridpoints of a deformable block, whose displacements and velocities are small ones, as above.
void turn_gridpoints(World& w, int block);
// Gives fixed frames to congruent blocks that have turned by less than that, before contact points are adopted;
// turns the others.
void begin_with_fixed_frames(World& w);
// Lets the frames of blocks that have turned follow them, after a step in which motion is checked.
void leave_fixed_frames(World& w);

}  // namespace quoin::blocks
