// Frames of deformable blocks outside of steps, and contact points whose block loses its frame.
#include "model/block_frames.h"

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// R of a matrix near a rotation: Newton's iteration R <- (R + R^-T)/2, whose error e becomes e^2/2.
Matrix rotation_in(const Matrix& f) {
  constexpr int kIterations = 5;  // a strain of 0.1 converges to rounding
  Matrix r = f;
  for (int i = 0; i < kIterations; ++i) r = 0.5 * (r + transposed(inverse(r)));
  return r;
}

}  // namespace

bool may_have_frame(const World& w, int block) {
  return !w.frames.by_zone[size_t(block)] && (w.blocks[size_t(block)].congruent >= 0 || !w.nodes.anchor.empty());
}

// Congruent blocks share a shape, which each block has rotated by its orientation. For others R starts at the identity.
Matrix start_of_frame(const World& w, int block) {
  return w.blocks[size_t(block)].congruent >= 0 ? matrix(w.assembly.blocks[size_t(block)].orientation) : Matrix{};
}

Matrix rotation_of_frame(const World& w, int block) {
  return w.is_small ? start_of_frame(w, block) : transposed(w.frames.frame[size_t(block)].transposed_r);
}

BlockFrame frame_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const size_t first = size_t(b.first_node), corners = b.shape->vertices.size();
  const Vector* const anchor =
      b.congruent >= 0 ? w.zones.congruent[size_t(b.congruent)].anchor.data() : w.nodes.anchor.data() + first;
  Matrix f = Matrix::zero();
  for (size_t n = 0; n < corners; ++n) f += outer(w.nodes.x[first + n] - w.nodes.x[first], anchor[n]);
  return {transposed(rotation_in(f)), f};
}

void find_block_frame(World& w, int i) {
  const ModelBlock& b = w.blocks[size_t(i)];
  if (b.body >= 0 || !w.part.laid_out[size_t(i)] || (b.congruent < 0 && w.nodes.anchor.empty())) return;
  if (w.frames.fixed[size_t(i)] && w.is_small) return;
  w.frames.frame[size_t(i)] = frame_of(w, i);
}

void find_block_frames(World& w) {
  w.frames.are_old = false;
  for (int i = 0; i < w.block_count(); ++i) find_block_frame(w, i);
}

double deformation_in(const World& w, const BlockFrame& frame, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const Matrix& back = frame.transposed_r;
  double largest = 0.0;
  for (size_t n = 0; n < size_t(b.node_count); ++n) {
    const size_t first = size_t(b.first_node);
    const Vector shape = b.congruent >= 0 ? w.zones.congruent[size_t(b.congruent)].place[n] -
                                                w.zones.congruent[size_t(b.congruent)].place[0]
                                          : w.nodes.reference[first + n] - w.nodes.reference[first];
    largest = std::max(largest, norm(back * (w.nodes.x[first + n] - w.nodes.x[first]) - shape));
  }
  return largest;
}

void leave_frames_of_deformed(World& w) {
  for (int i = 0; i < w.block_count(); ++i) {
    const ModelBlock& b = w.blocks[size_t(i)];
    if (b.body < 0 && may_have_frame(w, i) && !w.frames.fixed[size_t(i)] &&
        deformation_in(w, w.frames.frame[size_t(i)], i) > kLargestDeformation * b.least_extent)
      w.frames.by_zone[size_t(i)] = 1, w.pieces.are_old = true;
  }
}

}  // namespace quoin::blocks
