// What can be asked of a model.
#include <cstring>
#include <limits>

#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Of a field over the gridpoints of a deformable block.
template <class Masses, class Field>
Vector mass_mean(const ModelBlock& b, const Masses& node_mass, const Field& field) {
  Vector sum;
  double mass = 0.0;
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) sum += node_mass[i] * field[i], mass += node_mass[i];
  return sum / mass;
}

}  // namespace

Vector World::position(int block) const {
  const ModelBlock& b = blocks_[block];
  if (b.body >= 0) return bodies_[b.body].x;
  return mass_mean(b, node_mass_, node_x_);
}

Matrix World::orientation(int block) const {
  Vector x;
  Matrix r;
  pose(block, x, r);
  return r * transposed(start_r_[block]);
}

Vector World::velocity(int block) const {
  const ModelBlock& b = blocks_[block];
  if (b.body >= 0) return bodies_[b.body].v;
  return mass_mean(b, node_mass_, node_v_);
}

Vector World::angular_velocity(int block) const {
  const ModelBlock& b = blocks_[block];
  return b.body >= 0 ? bodies_[b.body].omega : Vector{};
}

Vector World::contact_force(int block) const { return block_contact_force_[block]; }

Matrix World::frame_of(const Point& p) const {
  if (p.facet_a >= 0 && !small_) {
    Point now = p;
    Facet facet = facets_[size_t(p.facet_a)];
    refresh_facet_frame(now, facet);
    return {{now.n, now.s, now.t}};
  }
  if (p.facet_a >= 0) return {{p.n, p.s, p.t}};
  const Matrix& r = bodies_[size_t(blocks_[size_t(p.a)].body)].r;
  return {{r * p.n, r * p.s, r * p.t}};
}

Vector World::corner(int block, int vertex) const {
  const ModelBlock& b = blocks_[block];
  if (b.body < 0) return node_x_[size_t(b.first_node) + size_t(vertex)];
  const Body& body = bodies_[b.body];
  return body.x + body.r * corner_[b.first_corner + size_t(vertex)];
}

std::vector<std::vector<Vector>> World::faces(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  std::vector<std::vector<Vector>> result;
  if (b.body >= 0) {
    for (const auto& face : b.shape->faces) {
      auto& corners = result.emplace_back();
      for (int v : face) corners.push_back(corner(block, v));
    }
    return result;
  }
  for (const auto& t : b.surface) result.push_back({node_x_[t.node[0]], node_x_[t.node[1]], node_x_[t.node[2]]});
  return result;
}

Matrix World::zone_stress(int z) const {
  const Zone& zone = zones_[z];
  Matrix f = Matrix::zero();
  for (int k = 0; k < 4; ++k) f += outer(node_x_[zone.node[k]], zone.gradient[k]);
  const Matrix strain = 0.5 * (transposed(f) * f - Matrix{});
  const Matrix second = 2 * zone.mu * strain + zone.lambda * trace(strain) * Matrix{};
  return 1 / determinant(f) * (f * second * transposed(f));
}

double Zone::energy(const Matrix& strain) const {
  double squares = 0.0;
  for (const Vector& row : strain.row) squares += dot(row, row);
  return volume * (0.5 * lambda * trace(strain) * trace(strain) + mu * squares);
}

double World::strain_energy() const {
  double sum = 0.0;
  for (const Zone& zone : zones_) {
    Matrix h = Matrix::zero();
    for (int k = 0; k < 4; ++k) h += outer(node_x_[zone.node[k]] - node_reference_[zone.node[k]], zone.gradient[k]);
    const Matrix e = 0.5 * (h + transposed(h) + transposed(h) * h);
    sum += zone.energy(e);
  }
  return sum;
}

double World::kinetic_energy() const {
  double sum = 0.0;
  for (const Body& b : bodies_) {
    for (int k = 0; k < 3; ++k)
      if (!(b.held >> k & 1)) sum += 0.5 * b.mass * b.v[k] * b.v[k];
    if ((b.held >> 3) != 7) sum += 0.5 * dot(b.momentum, b.omega);
  }
  for (size_t i = 0; i < node_v_.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double factor = node_held_[i] >> k & 1 ? 0.0 : solver_.deformation_inertia;
      sum += 0.5 * factor * node_mass_[i] * node_v_[i][k] * node_v_[i][k];
    }
  }
  for (int i = 0; splits_motion() && i < block_count(); ++i) {
    const Unit unit = unit_of(i);
    if (blocks_[size_t(i)].body < 0 && unit.block[0] == i) sum += rigid_kinetic_energy(unit);
  }
  return sum;
}

Vector World::linear_momentum() const {
  Vector p;
  for (const Body& b : bodies_) p += b.mass * b.v;
  for (size_t i = 0; i < node_x_.size(); ++i) p += node_mass_[i] * node_v_[i];
  return p;
}

Vector World::angular_momentum(const Vector& about) const {
  // Velocities live half a step before positions; x - v dt/2 brings both to the same time (cross(v, v) = 0).
  Vector l;
  for (const Body& b : bodies_) l += b.momentum + b.mass * cross(b.x - about, b.v);
  for (size_t i = 0; i < node_x_.size(); ++i) l += node_mass_[i] * cross(node_x_[i] - about, node_v_[i]);
  return l;
}

double World::unbalanced_ratio() const {
  double forces = 0.0;
  for (const Family& f : families_) {
    for (size_t i = 0; i < f.size(); ++i) {
      double square = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double t = f.traction[k][i] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][i]);
        square += t * t;
      }
      forces += f.area[i] * std::sqrt(square);
    }
  }
  if (unbalanced_ == 0.0) return 0.0;
  return forces > 0 ? unbalanced_ * double(point_count()) / forces : std::numeric_limits<double>::infinity();
}

size_t World::point_count() const {
  size_t count = 0;
  for (const Family& f : families_) count += f.size();
  return count;
}

double World::mass_of(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  if (b.body >= 0) return bodies_[size_t(b.body)].weight_mass;
  double sum = 0.0;
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) sum += node_weight_mass_[size_t(i)];
  return sum;
}

double World::mass() const {
  double m = 0.0;
  for (const Body& b : bodies_) m += b.weight_mass;
  for (double x : node_weight_mass_) m += x;
  return m;
}

uint64_t World::hash() const {
  uint64_t h = 1469598103934665603u;
  const auto add = [&](const void* data, size_t bytes) {
    const auto* p = static_cast<const unsigned char*>(data);
    for (size_t i = 0; i < bytes; ++i) h = (h ^ p[i]) * 1099511628211u;
  };
  for (const Body& b : bodies_)
    add(&b.x, sizeof b.x), add(&b.q, sizeof b.q), add(&b.v, sizeof b.v), add(&b.momentum, sizeof b.momentum);
  add(node_x_.data(), node_x_.size() * sizeof(Vector));
  add(node_v_.data(), node_v_.size() * sizeof(Vector));
  for (const Family& f : families_) {
    for (const auto& c : f.traction) add(c.data(), c.size() * sizeof(double));
    for (const auto& c : f.state) add(c.data(), c.size() * sizeof(double));
  }
  return h;
}

}  // namespace quoin::blocks
