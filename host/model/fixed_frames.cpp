#include "model/fixed_frames.h"

#include <algorithm>

#include "model/contact_frames.h"
#include "model/world.h"
#include "model/world_parts.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

double largest_fixed_rotation(const World& w) { return std::min(kFixedFrame, w.solver.motion_bound.rotation); }

namespace {

// The gridpoints of a deformable block at the start, and the small motion of each; m, m/s.
struct Displaced {
  std::span<const Vector> place;
  std::span<const double> mass;
  RigidInertia inertia;  // of the motions that a plane of symmetry leaves free
  std::vector<Vector> displacement;

  Displaced(const World& w, const ModelBlock& b)
      : place(w.nodes.reference.data() + b.first_node, size_t(b.node_count)),
        mass(w.nodes.mass.data() + b.first_node, size_t(b.node_count)),
        inertia(place, mass, {w.nodes.support.data() + b.first_node, size_t(b.node_count)}) {
    for (size_t n = 0; n < place.size(); ++n) displacement.push_back(w.nodes.x[size_t(b.first_node) + n] - place[n]);
  }
  Vector arm(size_t n) const { return place[n] - inertia.centre(); }
  // Rigid part of a field on the gridpoints: what is left has neither momentum nor angular momentum.
  Rigid rigid_part(std::span<const Vector> of) const {
    return inertia.acceleration(sum_about(inertia.centre(), place, of, mass));
  }
};

Vector at_arm(const Rigid& motion, const Vector& arm) { return motion.linear + cross(motion.angular, arm); }

// Whether the displacements of a block are still small: its rotation, and the largest displacement beside it. share: of
// the bounds.
bool keeps_fixed_frame(const World& w, int block, double share = 1.0) {
  const BlockFrame frame = frame_of(w, block);
  return angle_between(transposed(frame.transposed_r), start_of_frame(w, block)) <= share * largest_fixed_rotation(w) &&
         deformation_in(w, frame, block) <= share * kLargestDeformation * w.blocks[size_t(block)].least_extent;
}

// Turns the gridpoints of a deformable block, whose displacements and velocities are small ones.
void turn_gridpoints(World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const Displaced d(w, b);
  std::vector<Vector> velocity;
  for (int n = 0; n < b.node_count; ++n) velocity.push_back(gridpoint_velocity(w, block, n));
  const Rigid moved = d.rigid_part(d.displacement), moving = d.rigid_part(velocity);
  const Matrix turn = matrix(rotation(moved.angular));
  // The angular momentum stays, while the inertia turns.
  const Vector momentum = d.inertia.force(moving).angular;
  const Vector spin = turn * d.inertia.acceleration({{}, transposed_times(turn, momentum)}).angular;
  for (size_t n = 0; n < d.place.size(); ++n) {
    const Vector r = d.arm(n), turned = turn * (r + (d.displacement[n] - at_arm(moved, r)));
    const Vector x = d.inertia.centre() + moved.linear + turned;
    const Vector v = at_arm({moving.linear, spin}, turned) + turn * (velocity[n] - at_arm(moving, r));
    const size_t node = size_t(b.first_node) + n;
    for (int k = 0; k < 3; ++k) {
      if (w.nodes.held[node] >> k & 1) continue;
      w.nodes.x[node][k] = x[k], w.nodes.v[node][k] = v[k];
    }
  }
}

}  // namespace

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

// Share of the bounds from which on blocks leave their fixed frames as soon as one leaves past the bound. All work is
// divided again each time, which costs as much as tens of steps. A smaller share means fewer times, and frames that
// turn a little earlier.
constexpr double kLeavesTogether = 0.5;

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
  const bool moves_foot = p.facet_a >= 0 && !p.on_gridpoints && !w.is_small;
  if (moves_foot) {
    Facet& facet = w.contacts.facets[size_t(p.facet_a)];
    const TriangleFrame frame = triangle_frame(w.nodes.x, facet);
    take_axes(p, frame);
    const Location off = locate(w, p, w.contacts.facets);
    move_foot(facet, frame.gradient, off.slid[0], off.slid[1]);
  }
  const Location now = locate(w, p, w.contacts.facets);
  keep_opening(p, now.jump, moved.before.jump);
  for (int k = 0; k < 2 && !moves_foot; ++k) f.slid[k][moved.index] += now.slid[k] - moved.before.slid[k];
}

}  // namespace

void leave_fixed_frames(World& w) {
  if (w.stepping.count < w.checks.next || w.checks.block.empty()) return;
  if (std::ranges::none_of(w.frames.fixed, [](uint8_t is_fixed) { return is_fixed != 0; })) return;
  bool some = false;
  for (int i = 0; i < w.block_count() && !some; ++i) {
    const bool is_due = w.frames.fixed[size_t(i)] && w.part.owns(i) && w.checks.block[size_t(i)] <= w.stepping.count;
    some = is_due && !keeps_fixed_frame(w, i);
  }
  if (!w.part.any(some)) return;
  std::vector<double> leaves(w.blocks.size(), 0.0);  // by block; not 0: it leaves its fixed frame
  for (int i = 0; i < w.block_count(); ++i) {
    if (w.frames.fixed[size_t(i)] && w.part.owns(i) && !keeps_fixed_frame(w, i, kLeavesTogether))
      leaves[size_t(i)] = 1.0;
  }
  w.part.gather_by_block(leaves);
  for (const Piece& piece : w.pieces.all) {
    const auto blocks = w.pieces.blocks_of(piece);
    if (piece.fixed && std::ranges::any_of(blocks, [&](int32_t block) { return leaves[size_t(block)] > 0.0; }))
      for (const int32_t block : blocks) leaves[size_t(block)] = 1.0;
  }
  w.part.fetch();
  take_back_facets(w);
  copy_velocities(w);
  refresh_blocks(w, leaves);  // each step sends gridpoints at joints alone
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
