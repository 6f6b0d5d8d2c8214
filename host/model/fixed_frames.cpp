#include "model/fixed_frames.h"

#include <algorithm>

#include "model/contact_frames.h"
#include "model/world.h"
#include "model/world_results.h"

namespace quoin::blocks {

using namespace geometry;

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

// A block in small displacements, m and m/s by gridpoint, and the rigid parts of its motion.
struct Displaced {
  std::span<const Vector> place;
  std::span<const double> mass;
  std::vector<Vector> displacement, velocity;
  RigidPart moved, moving;
  bool on_plane = false;  // whether a plane of symmetry holds gridpoints
};

Displaced displaced(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  const auto first = size_t(b.first_node), count = size_t(b.node_count);
  Displaced m{{w.nodes.reference.data() + first, count}, {w.nodes.mass.data() + first, count}, {}, {}, {}, {}};
  for (size_t n = 0; n < count; ++n) {
    m.displacement.push_back(w.nodes.x[first + n] - m.place[n]);
    m.velocity.push_back(gridpoint_velocity(w, block, int(n)));
    m.on_plane |= w.nodes.support[first + n] != 0;
  }
  m.moved = rigid_part(m.place, m.mass, m.displacement, m.on_plane);
  m.moving = rigid_part(m.place, m.mass, m.velocity, m.on_plane);
  return m;
}

// Whether the small displacements of a block are still small: its rotation, and the largest displacement beside it.
bool keeps_fixed_frame(const World& w, int block) {
  const Displaced m = displaced(w, block);
  if (norm(m.moved.turn) > kFixedFrame) return false;
  const double bound = kLargestDeformation * w.blocks[size_t(block)].least_extent;
  for (size_t n = 0; n < m.place.size(); ++n) {
    const Vector rigid = m.moved.mean + cross(m.moved.turn, m.place[n] - m.moved.centre);
    if (!(norm(m.displacement[n] - rigid) <= bound)) return false;
  }
  return true;
}

}  // namespace

void turn_gridpoints(World& w, int block) {
  const Displaced m = displaced(w, block);
  const auto first = size_t(w.blocks[size_t(block)].first_node);
  const Matrix turn = matrix(rotation(m.moved.turn));
  // The angular momentum stays: the inertia has turned.
  const Vector spin =
      m.on_plane ? m.moving.turn
                 : turn * (inverse(m.moving.inertia) * transposed_times(turn, m.moving.inertia * m.moving.turn));
  for (size_t n = 0; n < m.place.size(); ++n) {
    const Vector r = m.place[n] - m.moved.centre;
    const Vector turned = turn * (r + (m.displacement[n] - m.moved.mean - cross(m.moved.turn, r)));
    const Vector x = m.moved.centre + m.moved.mean + turned;
    const Vector v =
        m.moving.mean + cross(spin, turned) + turn * (m.velocity[n] - m.moving.mean - cross(m.moving.turn, r));
    for (int k = 0; k < 3; ++k) {
      if (w.nodes.held[first + n] >> k & 1) continue;
      w.nodes.x[first + n][k] = x[k], w.nodes.v[first + n][k] = v[k];
    }
  }
}

void begin_with_fixed_frames(World& w) {
  copy_velocities(w);
  for (int i = 0; i < w.block_count(); ++i) {
    w.frames.fixed[size_t(i)] = 0;
    if (w.blocks[size_t(i)].body >= 0) continue;
    const Unit unit = w.units.of(i);
    w.frames.fixed[size_t(i)] = std::ranges::all_of(unit.blocks(), [&](int block) {
      return w.blocks[size_t(block)].congruent >= 0 && keeps_fixed_frame(w, block);
    });
    if (!w.frames.fixed[size_t(i)]) turn_gridpoints(w, i);
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
  std::vector<double> leaves(w.blocks.size(), 0.0);  // not 0: the block leaves its fixed frame
  bool some = false;
  for (int i = 0; i < w.block_count(); ++i) {
    if (!w.frames.fixed[size_t(i)] || !w.part.owns(i) || w.checks.block[size_t(i)] > w.stepping.count) continue;
    if (leaves[size_t(i)] > 0.0 || keeps_fixed_frame(w, i)) continue;
    const int32_t piece = w.pieces.of_block[size_t(i)];
    for (const int32_t block : w.pieces.blocks_of(piece)) leaves[size_t(block)] = 1.0;
    some = true;
  }
  if (!w.part.any(some)) return;
  w.part.gather_by_block(leaves);
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
