#include "model/fixed_frames.h"

#include <algorithm>

#include "model/contact_frames.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

double largest_fixed_rotation(const World& w) { return std::min(kFixedFrame, w.solver.motion_bound.rotation); }

RigidPart rigid_part(std::span<const Vector> place, std::span<const double> mass, std::span<const Vector> of,
                     bool symmetry_plane) {
  RigidPart part;
  double sum = 0.0;
  for (size_t i = 0; i < place.size(); ++i) {
    sum += mass[i];
    part.centre += mass[i] * place[i];
    part.mean += mass[i] * of[i];
  }
  part.centre = part.centre / sum, part.mean = part.mean / sum;
  part.inertia = Matrix::zero();
  Vector moment;
  for (size_t i = 0; i < place.size(); ++i) {
    const Vector r = place[i] - part.centre;
    part.inertia += mass[i] * (dot(r, r) * Matrix{} - outer(r, r));
    moment += mass[i] * cross(r, of[i]);
  }
  if (symmetry_plane) {
    part.mean.z = 0.0;
    part.turn = {0.0, 0.0, moment.z / part.inertia.row[2].z};
  } else {
    part.turn = inverse(part.inertia) * moment;
  }
  return part;
}

namespace {

std::vector<Vector> displacements_of(const World& w, const ModelBlock& b) {
  std::vector<Vector> u;
  for (size_t n = size_t(b.first_node); n < size_t(b.first_node + b.node_count); ++n)
    u.push_back(w.nodes.x[n] - w.nodes.reference[n]);
  return u;
}

// Rigid part of a field on the gridpoints of a block.
RigidPart rigid_part_of(const World& w, const ModelBlock& b, std::span<const Vector> of) {
  const auto first = size_t(b.first_node), count = size_t(b.node_count);
  const auto support = std::span(w.nodes.support).subspan(first, count);
  const bool on_plane = std::ranges::any_of(support, [](uint8_t bits) { return bits != 0; });
  return rigid_part({w.nodes.reference.data() + first, count}, {w.nodes.mass.data() + first, count}, of, on_plane);
}

// Whether the displacements of a block are still small: its rotation, and the largest displacement beside rigid motion.
bool keeps_fixed_frame(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const std::vector<Vector> u = displacements_of(w, b);
  const RigidPart moved = rigid_part_of(w, b, u);
  if (norm(moved.turn) > largest_fixed_rotation(w)) return false;
  for (size_t n = 0; n < u.size(); ++n) {
    const Vector r = w.nodes.reference[size_t(b.first_node) + n] - moved.centre;
    if (!(norm(u[n] - moved.mean - cross(moved.turn, r)) <= kLargestDeformation * b.least_extent)) return false;
  }
  return true;
}

}  // namespace

void turn_gridpoints(World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const auto first = size_t(b.first_node);
  const std::vector<Vector> u = displacements_of(w, b);
  std::vector<Vector> velocity;
  for (int n = 0; n < b.node_count; ++n) velocity.push_back(gridpoint_velocity(w, block, n));
  const RigidPart moved = rigid_part_of(w, b, u), moving = rigid_part_of(w, b, velocity);
  const Matrix turn = matrix(rotation(moved.turn));
  // The angular momentum stays, while the inertia turns; about the normal of a plane of symmetry both stay.
  const Vector turned_spin = turn * (inverse(moving.inertia) * transposed_times(turn, moving.inertia * moving.turn));
  const Vector spin = w.assembly.symmetry_plane_z0 ? moving.turn : turned_spin;
  for (size_t n = 0; n < u.size(); ++n) {
    const Vector r = w.nodes.reference[first + n] - moved.centre;
    const Vector turned = turn * (r + (u[n] - moved.mean - cross(moved.turn, r)));
    const Vector x = moved.centre + moved.mean + turned;
    const Vector v = moving.mean + cross(spin, turned) + turn * (velocity[n] - moving.mean - cross(moving.turn, r));
    for (int k = 0; k < 3; ++k) {
      if (w.nodes.held[first + n] >> k & 1) continue;
      w.nodes.x[first + n][k] = x[k], w.nodes.v[first + n][k] = v[k];
    }
  }
}

void begin_with_fixed_frames(World& w) {
  copy_velocities(w);
  for (int i = 0; i < w.block_count(); ++i)
    w.frames.fixed[size_t(i)] = w.blocks[size_t(i)].congruent >= 0 && keeps_fixed_frame(w, i);
  for (int i = 0; i < w.block_count(); ++i) {
    const int other = w.units.other_half[size_t(i)];
    if (other >= 0 && !w.frames.fixed[size_t(other)]) w.frames.fixed[size_t(i)] = 0;
    if (w.blocks[size_t(i)].body < 0 && !w.frames.fixed[size_t(i)]) turn_gridpoints(w, i);
  }
  w.pieces.are_old = w.pieces.motion_is_old = w.frames.are_old = true;
}

namespace {

// A contact point at a block that leaves its fixed frame, and where it was.
struct MovedPoint {
  Family* family;
  size_t index;
  Location before;
};

std::vector<MovedPoint> points_at(World& w, const std::vector<double>& leaves) {
  std::vector<MovedPoint> points;
  for (Family& f : w.contacts.families) {
    for (size_t i = 0; i < f.size(); ++i) {
      const Point& p = f.point[i];
      const bool is_here = w.part.laid_out[size_t(p.a)] && w.part.laid_out[size_t(p.b)];
      if (is_here && (leaves[size_t(p.a)] > 0.0 || leaves[size_t(p.b)] > 0.0))
        points.push_back({&f, i, locate(w, p, w.contacts.facets)});
    }
  }
  return points;
}

// Opening and slip of a point stay.
void follow(World& w, const MovedPoint& moved) {
  Family& f = *moved.family;
  Point& p = f.point[moved.index];
  const bool on_triangle = p.facet_a >= 0 && !p.on_gridpoints;
  if (on_triangle && !w.is_small) {
    Facet& facet = w.contacts.facets[size_t(p.facet_a)];
    const TriangleFrame frame = triangle_frame(w.nodes.x, facet);
    take_axes(p, frame);
    const Location now = locate(w, p, w.contacts.facets);
    move_foot(facet, frame.gradient, now.slid[0], now.slid[1]);
  }
  const Location now = locate(w, p, w.contacts.facets);
  p.reference += now.jump - moved.before.jump;
  if (p.facet_a < 0) p.offset += now.jump - moved.before.jump;
  for (int k = 0; k < 2 && !(on_triangle && !w.is_small); ++k)
    f.slid[k][moved.index] += now.slid[k] - moved.before.slid[k];
}

}  // namespace

void leave_fixed_frames(World& w) {
  if (w.stepping.count < w.checks.next || w.checks.block.empty()) return;
  if (std::ranges::none_of(w.frames.fixed, [](uint8_t is_fixed) { return is_fixed != 0; })) return;
  std::vector<double> leaves(w.blocks.size(), 0.0);  // by block; not 0: it leaves its fixed frame
  bool some = false;
  for (int i = 0; i < w.block_count(); ++i) {
    const bool is_due = w.frames.fixed[size_t(i)] && w.part.owns(i) && w.checks.block[size_t(i)] <= w.stepping.count;
    if (is_due && !keeps_fixed_frame(w, i)) leaves[size_t(i)] = 1.0, some = true;
  }
  if (!w.part.any(some)) return;
  w.part.gather_by_block(leaves);
  for (const Piece& piece : w.pieces.all) {
    const auto blocks = w.pieces.blocks_of(piece);
    if (piece.fixed && std::ranges::any_of(blocks, [&](int32_t block) { return leaves[size_t(block)] > 0.0; }))
      for (const int32_t block : blocks) leaves[size_t(block)] = 1.0;
  }
  w.part.fetch();
  take_back_facets(w);
  copy_velocities(w);
  const std::vector<MovedPoint> points = points_at(w, leaves);
  for (int i = 0; i < w.block_count(); ++i) {
    if (leaves[size_t(i)] == 0.0) continue;
    w.frames.fixed[size_t(i)] = 0;
    if (w.part.laid_out[size_t(i)]) turn_gridpoints(w, i), find_block_frame(w, i);
  }
  for (const MovedPoint& point : points) follow(w, point);
  w.pieces.are_old = w.pieces.motion_is_old = true;
  divide_work(w);
}

}  // namespace quoin::blocks
