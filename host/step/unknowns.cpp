#include "step/unknowns.h"

#include <algorithm>
#include <limits>

#include "model/world_results.h"
#include "step/lattice_motion.h"
#include "step/reactions.h"
#include "step/results.h"

namespace quoin {
namespace {

using geometry::Matrix;
using geometry::Vector;

// Stress of a zone on the lattice, Pa, from the displacements of its block's gridpoints, m.
Matrix stress_of(const BrickTemplate& shape, const Zone& zone, const std::vector<Vector>& moved) {
  Matrix stress = Matrix::zero();
  for (std::size_t a = 0; a < 4; ++a) {
    const Vector& w = moved[at(zone.node[a])];
    const Vector gradient = geometry::vector(zone.shape_gradient[a]);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) stress.row[c][k] += shape.shear_modulus * (w[c] * gradient[k] + w[k] * gradient[c]);
      stress.row[c][c] += shape.lambda * dot(w, gradient);
    }
  }
  return stress;
}

}  // namespace

void each_stressed_zone(const Simulation::Impl& s, int block, const std::function<void(const StressedZone&)>& visit) {
  if (s.large_motion) {
    const Matrix turned = turn_of_frame(*s.large_motion, block);
    for (int z = 0; z < s.large_motion->blocks[block].zone_count; ++z) {
      const blocks::Zone zone = zone_of(*s.large_motion, block, z);
      StressedZone now{{}, {}, zone.volume, zone.lambda, zone.mu, zone_stress(*s.large_motion, block, z)};
      for (std::size_t i = 0; i < 4; ++i) now.node[i] = zone.node[i], now.gradient[i] = turned * zone.gradient[i];
      visit(now);
    }
    return;
  }
  const BrickTemplate& shape = s.model.template_of(block);
  std::vector<Vector> moved;
  s.model.for_each_gridpoint(block, [&](std::size_t o, double) {
    moved.push_back(geometry::vector(at_gridpoint(s.lattice.displacement, o)));
  });
  for (const Zone& zone : shape.zone) {
    StressedZone now{zone.node, {}, zone.volume, shape.lambda, shape.shear_modulus, stress_of(shape, zone, moved)};
    for (std::size_t i = 0; i < 4; ++i) now.gradient[i] = geometry::vector(zone.shape_gradient[i]);
    visit(now);
  }
}

Unknowns::Unknowns(const Simulation::Impl& s) : s_(s) {
  groups_.begin = {0};
  const std::vector<std::uint8_t> held = held_now(s);  // blocks take these with the next step
  for (int b = 0; b < block_count(s); ++b) {
    blocks_.emplace_back();
    s_.large_motion ? number_large_motion(b, held[at(b)]) : number_lattice(b, held[at(b)]);
  }
}
void Unknowns::close_group(int block, const Vector& place) {
  if (count_ == groups_.begin.back()) return;
  groups_.begin.push_back(count_), groups_.place.push_back(place);
  block_of_group_.push_back(block);
}

void Unknowns::number_lattice(int b, unsigned held) {
  OfBlock& u = blocks_.back();
  const int body = s_.model.place[at(b)].body;
  if (body >= 0) {
    const RigidBody& rigid = s_.model.bodies[at(body)];
    u.rigid = true, u.centre = geometry::vector(rigid.centre);
    for (std::size_t c = 0; c < 6; ++c) u.body[c] = next(rigid.held[c] || (held >> c & 1u) != 0);
    return close_group(b, u.centre);
  }
  s_.model.for_each_gridpoint(b, [&](std::size_t offset, double) {
    auto& of_point = u.gridpoint.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) of_point[c] = next(s_.inertia.dt_over_mass[offset + c * kLanes] == 0.0);
    close_group(b, geometry::vector(s_.model.gridpoint_position(b, static_cast<int>(u.gridpoint.size()) - 1)));
  });
}

void Unknowns::number_large_motion(int b, unsigned held) {
  OfBlock& u = blocks_.back();
  const blocks::ModelBlock& block = s_.large_motion->blocks[b];
  if (block.body >= 0) {
    const blocks::Body& body = body_of(*s_.large_motion, b);
    u.rigid = true, u.centre = body.x;
    for (unsigned c = 0; c < 6; ++c) u.body[c] = next(((held | body.support) >> c & 1u) != 0);
    return close_group(b, u.centre);
  }
  const bool halved = s_.large_motion->assembly.symmetry_plane_z0;
  for (int n = block.first_node; n < block.first_node + block.node_count; ++n) {
    auto& of_point = u.gridpoint.emplace_back();
    const bool on_plane = halved && s_.large_motion->nodes.reference[at(n)].z == 0.0;
    for (unsigned c = 0; c < 3; ++c) of_point[c] = next((held >> c & 1u) != 0 || (on_plane && c == 2));
    close_group(b, s_.large_motion->nodes.x[at(n)]);
  }
}

// Adds V (lambda g_i g_j^T + mu g_j g_i^T + mu (g_i . g_j) I) for nodes i and j, g the gradients of shape functions.
void Unknowns::add_zones(Entries* entries) const {
  for (int b = 0; b < static_cast<int>(blocks_.size()); ++b) {
    const OfBlock& u = blocks_[at(b)];
    if (u.rigid) continue;
    each_stressed_zone(s_, b, [&](const StressedZone& zone) {
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          const Vector &gi = zone.gradient[i], &gj = zone.gradient[j];
          const double along = zone.mu * dot(gi, gj);
          for (int c = 0; c < 3; ++c) {
            const int row = u.gridpoint[at(zone.node[i])][at(c)];
            for (int d = 0; row >= 0 && d < 3; ++d) {
              const int column = u.gridpoint[at(zone.node[j])][at(d)];
              if (column < 0 || column > row) continue;
              const double k = zone.lambda * gi[c] * gj[d] + zone.mu * gj[c] * gi[d];
              entries->emplace_back(row, column, zone.volume * (k + (c == d ? along : 0.0)));
            }
          }
        }
      }
    });
  }
}

void Unknowns::shares_of(const ContactPoint& p, std::vector<UnknownShare>* shares) const {
  shares->clear();
  add_side(p, p.block_a, -1.0, shares);
  add_side(p, p.block_b, 1.0, shares);
}

void Unknowns::add_side(const ContactPoint& p, int b, double sign, std::vector<UnknownShare>* shares) const {
  const OfBlock& u = blocks_[at(b)];
  const Vector place = geometry::vector(p.position);
  const auto add = [&](const std::array<int, 3>& unknown, double weight) {
    for (int c = 0; c < 3; ++c) {
      if (unknown[at(c)] < 0 || weight == 0.0) continue;
      UnknownShare share{unknown[at(c)], {}};
      share.moves[c] = sign * weight;
      shares->push_back(share);
    }
  };
  if (u.rigid) {
    add({u.body[0], u.body[1], u.body[2]}, 1.0);
    for (int c = 0; c < 3; ++c) {
      Vector spin{};
      spin[c] = sign;
      if (u.body[at(c + 3)] >= 0) shares->push_back({u.body[at(c + 3)], cross(spin, place - u.centre)});
    }
  } else if (s_.large_motion) {
    const auto [node, weight] = on_surface(b, place);
    for (std::size_t i = 0; i < 3; ++i)
      add(u.gridpoint[at(node[i] - s_.large_motion->blocks[b].first_node)], weight[i]);
  } else {
    add(u.gridpoint[at(gridpoint_at(b, place))], 1.0);
  }
}

// Corners of the surface triangle that is closest to a position, and their weights there.
std::pair<std::array<int, 3>, std::array<double, 3>> Unknowns::on_surface(int b, const Vector& place) const {
  const auto& x = s_.large_motion->nodes.x;
  std::pair<std::array<int, 3>, std::array<double, 3>> best{};
  double least = std::numeric_limits<double>::infinity();
  for (const auto& triangle : s_.large_motion->blocks[b].surface) {
    const Vector &p = x[at(triangle.node[0])], &q = x[at(triangle.node[1])], &r = x[at(triangle.node[2])];
    const Vector normal = cross(q - p, r - p);
    const double twice = dot(normal, normal);
    std::array<double, 3> weight{dot(cross(q - place, r - place), normal) / twice,
                                 dot(cross(r - place, p - place), normal) / twice, 0.0};
    weight[2] = 1.0 - weight[0] - weight[1];
    double sum = 0.0;
    for (double& w : weight) w = std::max(0.0, w), sum += w;
    for (double& w : weight) w /= sum;
    const double distance = norm(weight[0] * p + weight[1] * q + weight[2] * r - place);
    if (distance < least) least = distance, best = {triangle.node, weight};
  }
  return best;
}

// On the lattice contact points lie at gridpoints of both blocks.
int Unknowns::gridpoint_at(int b, const Vector& place) const {
  int nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < static_cast<int>(blocks_[at(b)].gridpoint.size()); ++n) {
    const double distance = norm(geometry::vector(s_.model.gridpoint_position(b, n)) - place);
    if (distance < least) least = distance, nearest = n;
  }
  return nearest;
}

void Unknowns::add_point(const ContactPoint& p, double normal, double shear, Entries* entries) const {
  std::vector<UnknownShare> shares;
  shares_of(p, &shares);
  const Vector n = geometry::vector(p.normal);
  for (const UnknownShare& row : shares) {
    const Vector force = shear * row.moves + (normal - shear) * dot(n, row.moves) * n;
    for (const UnknownShare& column : shares)
      if (column.unknown <= row.unknown) entries->emplace_back(row.unknown, column.unknown, dot(force, column.moves));
  }
}

// For a zone V (g_i . stress g_j) I.
void Unknowns::add_stresses(const std::vector<ContactPoint>& points, Entries* entries) const {
  for (int b = 0; b < static_cast<int>(blocks_.size()); ++b) {
    const OfBlock& u = blocks_[at(b)];
    if (u.rigid) continue;
    each_stressed_zone(s_, b, [&](const StressedZone& zone) {
      for (std::size_t i = 0; i < 4; ++i) {
        for (std::size_t j = 0; j < 4; ++j) {
          const double k = zone.volume * dot(zone.gradient[i], zone.stress * zone.gradient[j]);
          for (std::size_t c = 0; c < 3; ++c) {
            const int row = u.gridpoint[at(zone.node[i])][c], column = u.gridpoint[at(zone.node[j])][c];
            if (column >= 0 && column <= row) entries->emplace_back(row, column, k);
          }
        }
      }
    });
  }
  for (const ContactPoint& p : points) {
    const Vector force = p.area * (p.traction[0] * geometry::vector(p.normal) + p.traction[1] * geometry::vector(p.s) +
                                   p.traction[2] * geometry::vector(p.t));
    for (const auto& [block, sign] : {std::pair{p.block_a, 1.0}, {p.block_b, -1.0}})
      add_force(block, sign * force, geometry::vector(p.position) - blocks_[at(block)].centre, entries);
  }
}

// A force F on the arm r of a block turns about it by theta. Its work of second order is F . theta x (theta x r)/2,
// whose stiffness is (F . r) I - (F r^T + r F^T)/2. A force through the centre has none.
void Unknowns::add_force(int block, const Vector& f, const Vector& r, Entries* entries) const {
  const OfBlock& u = blocks_[at(block)];
  for (int c = 0; u.rigid && c < 3; ++c) {
    for (int d = 0; d < 3; ++d) {
      const int row = u.body[at(c + 3)], column = u.body[at(d + 3)];
      if (column < 0 || column > row) continue;
      entries->emplace_back(row, column, (c == d ? dot(f, r) : 0.0) - 0.5 * (f[c] * r[d] + r[c] * f[d]));
    }
  }
}

void add_turning(const std::array<int, 3>& forces, const std::array<int, 3>& motions, const Vector& v,
                 Unknowns::Entries* entries) {
  for (int d = 0; d < 3; ++d) {
    Vector motion;
    motion[d] = 0.5;
    const Vector half = cross(v, motion);
    for (int c = 0; c < 3; ++c) {
      const auto [column, row] = std::minmax(forces[at(c)], motions[at(d)]);
      if (c != d && column >= 0) entries->emplace_back(row, column, half[c]);
    }
  }
}

}  // namespace quoin
