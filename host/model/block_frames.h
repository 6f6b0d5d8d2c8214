// Co-rotational frames of deformable blocks whose strains are small.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

using geometry::Matrix;

// Co-rotational frame of a deformable block at the current positions of its gridpoints (step/deformable_kernels.h).
struct BlockFrame {
  Matrix transposed_r;  // transpose of R, which rotates the undeformed shape into space
  Matrix f;             // F = R U = sum x b^T
};

// Bound of |u| in a frame over the least extent of the block. Above it the block's forces are computed zone by zone.
// The frame's error of stiffness there is 1 %.
inline constexpr double kLargestDeformation = 0.01;

// Steps update the frames, and mark blocks that deform too much for theirs.
struct BlockFrames {
  LaneVector<BlockFrame> frame;  // frames of deformable blocks that have one
  bool are_old = true;           // whether gridpoints have moved outside of steps since then
  std::vector<uint8_t> by_zone;  // by block: 1 where forces are computed zone by zone
  // By block: 1 where internal forces are in the frame of the start, as on the lattice. Axes of contact points follow
  // the block there too.
  std::vector<uint8_t> fixed;
};

bool may_have_frame(const World& w, int block);       // whether a block is deformable and not computed by zone
Matrix start_of_frame(const World& w, int block);     // R of a deformable block at the start
Matrix rotation_of_frame(const World& w, int block);  // current R; in small displacements R at the start
BlockFrame frame_of(const World& w, int block);       // that of its current gridpoints
// Largest |u| of a deformable block in a frame, from its first gridpoint, m.
double deformation_in(const World& w, const BlockFrame& frame, int block);
void find_block_frames(World& w);            // computes the frames of all blocks that are laid out
void find_block_frame(World& w, int block);  // that of the start in small displacements
void leave_frames_of_deformed(World& w);

}  // namespace quoin::blocks
