// Frames of deformable blocks, outside of steps; and contact points that leave them.
#include <tuple>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// R of a matrix near a rotation: Newton's iteration R <- (R + R^-T)/2, whose error e becomes e^2/2.
Matrix rotation_in(const Matrix& f) {
  constexpr int kIterations = 5;  // a strain of a tenth goes to rounding
  Matrix r = f;
  for (int i = 0; i < kIterations; ++i) r = 0.5 * (r + transposed(inverse(r)));
  return r;
}

}  // namespace

std::pair<double, double> World::turned_into(const Vector& s, const Vector& t, const Vector& v) {
  const double along_s = dot(v, s), along_t = dot(v, t);
  const double size = std::sqrt(along_s * along_s + along_t * along_t), keep = size > 0 ? norm(v) / size : 1.0;
  return {keep * along_s, keep * along_t};
}

// Congruent blocks share a shape, which each has turned by its orientation. Others have the shape as it stands.
Matrix World::start_of_frame(int block) const {
  return blocks_[size_t(block)].congruent >= 0 ? matrix(assembly_.blocks[size_t(block)].orientation) : Matrix{};
}

Matrix World::rotation_of_frame(int block) const {
  return small_ ? start_of_frame(block) : transposed(frames_.frame[size_t(block)].transposed_r);
}

void World::find_block_frames() {
  frames_.are_old = false;
  for (int i = 0; i < block_count(); ++i) {
    const ModelBlock& b = blocks_[size_t(i)];
    if (b.body >= 0 || !part_.laid_out[size_t(i)] || (b.congruent < 0 && nodes_.anchor.empty())) continue;
    const Vector* const anchor =
        b.congruent >= 0 ? zones_.congruent[size_t(b.congruent)].anchor.data() : nodes_.anchor.data() + b.first_node;
    Matrix f = Matrix::zero();
    for (int n = 0; n < b.node_count; ++n)
      f += outer(nodes_.x[size_t(b.first_node + n)] - nodes_.x[size_t(b.first_node)], anchor[n]);
    frames_.frame[size_t(i)] = {transposed(rotation_in(f)), f};
  }
}

// The largest |u| beside the first gridpoint, as a step finds it, m.
double World::deformation(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  const Matrix& back = frames_.frame[size_t(block)].transposed_r;
  double largest = 0.0;
  for (size_t n = 0; n < size_t(b.node_count); ++n) {
    const size_t first = size_t(b.first_node);
    const Vector shape = b.congruent >= 0 ? zones_.congruent[size_t(b.congruent)].place[n] -
                                                zones_.congruent[size_t(b.congruent)].place[0]
                                          : nodes_.reference[first + n] - nodes_.reference[first];
    largest = std::max(largest, norm(back * (nodes_.x[first + n] - nodes_.x[first]) - shape));
  }
  return largest;
}

void World::leave_frames_of_deformed() {
  for (int i = 0; i < block_count(); ++i) {
    const ModelBlock& b = blocks_[size_t(i)];
    if (b.body < 0 && may_have_frame(i) && deformation(i) > kLargestDeformation * b.least_extent)
      frames_.by_zone[size_t(i)] = 1;
  }
}

// The foot goes to below the point, vectors of the joint are turned into the axes of the triangle. The opening stays,
// and what the law has not seen yet of the slip.
void World::leave_gridpoints(Family& f, size_t i) {
  Point& p = f.point[i];
  Facet& facet = contacts_.facets[size_t(p.facet_a)];
  const Location before = locate(p, contacts_.facets);
  const Matrix then = frame_of(p);
  p.on_gridpoints = false;
  refresh_facet_frame(p, facet);
  const auto turn = [&](const auto& then_s, const auto& then_t, auto& now_s, auto& now_t) {
    std::tie(now_s[i], now_t[i]) = turned_into(p.s, p.t, then_s[i] * then.row[1] + then_t[i] * then.row[2]);
  };
  turn_joint_vectors(f, f, turn);
  for (int k = 0; k < 2; ++k) f.slid[k][i] -= before.slid[k];
  turn(f.slid[0], f.slid[1], f.slid[0], f.slid[1]);
  const Location now = locate(p, contacts_.facets);
  for (int k = 0; k < 3; ++k)
    facet.weight[k] += facet.gradient[k][0] * now.slid[0] + facet.gradient[k][1] * now.slid[1];
  p.reference += locate(p, contacts_.facets).jump - before.jump;
}

}  // namespace quoin::blocks
