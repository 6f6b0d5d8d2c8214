// Frames that stay those of the start, as on the lattice, and blocks that leave them.
//
// In a fixed frame R displacements are small. Forces are -R (K u - q x b), u = R^T (x - x_0), with 2 q the moment of
// contact points on the frame (deformable_kernels.h). The axes of contact points follow the block, as the work of that
// moment is on its rotation. In small displacements they stay, and there is no moment. Arms are those of the start. A
// block that turns by more than kFixedFrame, or solver.rotation_bound, gets a frame that follows it (block_frames.h),
// with all blocks of its piece. The rigid part of its displacement then becomes a rotation,
//   x_0 + mean + theta x r + d  ->  c + mean + R(theta) (r + d),   r from the mass centre c,
// where d has neither momentum nor angular momentum. So strains, openings, slip and the momentum stay, and no energy is
// gained or lost but that of d turned by theta. Members at its gridpoints move by theta^2/2 r. Limit: theta = 0 changes
// nothing.
#pragma once

namespace quoin::blocks {

struct World;

// Rotation from which on a frame follows its block, rad. A fixed frame mistakes a rotation theta for a strain
// theta^2/2: 1.3e-5 at this bound, a seventh of what the lattice allows (0.013 rad).
inline constexpr double kFixedFrame = 5e-3;
double largest_fixed_rotation(const World& w);  // that, or solver.rotation_bound where it is less

// Gives fixed frames to congruent blocks that have turned by less than that, and turns the others, before
// contact points are adopted.
void begin_with_fixed_frames(World& w);
// Lets the frames of blocks that have turned follow them, after a step in which motion is checked.
void leave_fixed_frames(World& w);

}  // namespace quoin::blocks
