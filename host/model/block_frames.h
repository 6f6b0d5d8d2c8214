// Frames of deformable blocks that deform little.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/vector.h"
#include "model/lanes.h"

namespace quoin::blocks {

struct World;

using geometry::Matrix;

// The frame of a deformable block that deforms little (step/deformable_kernels.h), as its gridpoints stand.
struct BlockFrame {
  Matrix transposed_r;  // transpose of R, which leads from the undeformed shape to space
  Matrix f;             // F = R U = sum x b^T
};

// |u| of a frame over the least extent of its block, beyond which it goes zone by zone: error of its stiffness 1 %.
inline constexpr double kLargestDeformation = 0.01;

// By block. Steps find the frames, and which blocks leave theirs.
struct BlockFrames {
  LaneVector<BlockFrame> frame;  // frames of deformable blocks that have one
  bool are_old = true;           // gridpoints have been moved from outside
  std::vector<uint8_t> by_zone;  // 1: it has deformed too much for a frame
};

bool may_have_frame(const World& w, int block);       // deformable
Matrix start_of_frame(const World& w, int block);     // R of a deformable block at the start
Matrix rotation_of_frame(const World& w, int block);  // current one; in small displacements that of the start
void find_block_frames(World& w);                     // frames of all blocks that are laid out
void leave_frames_of_deformed(World& w);

}  // namespace quoin::blocks
