// What can be asked of a model.
#include <bit>
#include <cstring>
#include <limits>

#include "base/fnv_hash.h"
#include "members/members.h"
#include "model/fields.h"
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
  return mass_mean(b, nodes_.mass, nodes_.x);
}

Vector World::start_position(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  if (b.body >= 0) return poses_.start[size_t(block)].x;
  return mass_mean(b, nodes_.mass, nodes_.reference);
}

Matrix World::orientation(int block) const {
  Vector x;
  Matrix r;
  pose(block, x, r);
  return r * transposed(poses_.start[size_t(block)].r);
}

double World::turned_by_now(int block) const {
  const Matrix r = transposed(orientation(block));
  // |R - 1|^2 = 8 sin^2(angle / 2), which keeps its digits at small angles.
  double squares = 0.0;
  for (int k = 0; k < 3; ++k) {
    for (int c = 0; c < 3; ++c) {
      const double d = r.row[k][c] - (k == c ? 1.0 : 0.0);
      squares += d * d;
    }
  }
  return 2.0 * std::asin(std::min(1.0, std::sqrt(squares / 8.0)));
}

Vector World::velocity(int block) const {
  const ModelBlock& b = blocks_[block];
  if (b.body >= 0) return bodies_[b.body].v;
  return mass_mean(b, nodes_.mass, nodes_.v);
}

Vector World::angular_velocity(int block) const {
  const ModelBlock& b = blocks_[block];
  return b.body >= 0 ? bodies_[b.body].omega : Vector{};
}

Vector World::contact_force(int block) const { return step_sums_.contact_force[block]; }

Matrix World::frame_of(const Point& p) const {
  if (p.on_gridpoints) {
    const Matrix r = rotation_of_frame(p.a);
    return {{r * p.n, r * p.s, r * p.t}};
  }
  if (p.facet_a >= 0 && !small_) {
    Point now = p;
    Facet facet = contacts_.facets[size_t(p.facet_a)];
    refresh_facet_frame(now, facet);
    return {{now.n, now.s, now.t}};
  }
  if (p.facet_a >= 0) return {{p.n, p.s, p.t}};
  const Matrix& r = bodies_[size_t(blocks_[size_t(p.a)].body)].r;
  return {{r * p.n, r * p.s, r * p.t}};
}

Vector World::corner(int block, int vertex) const {
  const ModelBlock& b = blocks_[block];
  if (b.body < 0) return nodes_.x[size_t(b.first_node) + size_t(vertex)];
  const Body& body = bodies_[b.body];
  return body.x + body.r * shapes_.corner[b.first_corner + size_t(vertex)];
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
  for (const auto& t : b.surface) result.push_back({nodes_.x[t.node[0]], nodes_.x[t.node[1]], nodes_.x[t.node[2]]});
  return result;
}

size_t World::zone_count() const {
  size_t count = 0;
  for (const ModelBlock& b : blocks_) count += size_t(b.zone_count);
  return count;
}

Matrix World::zone_stress(int block, int z) const {
  const Zone zone = this->zone(block, z);
  const Vector* const x = nodes_.x.data() + blocks_[size_t(block)].first_node;
  Matrix f = Matrix::zero();
  for (int k = 0; k < 4; ++k) f += outer(x[zone.node[k]], zone.gradient[k]);
  const Matrix strain = 0.5 * (transposed(f) * f - Matrix{});
  const Matrix second = 2 * zone.mu * strain + zone.lambda * trace(strain) * Matrix{};
  return 1 / determinant(f) * (f * second * transposed(f));
}

double World::strain_energy() const {
  double sum = 0.0;
  each_zone([&](const ModelBlock& b, const Zone& zone) {
    Matrix h = Matrix::zero();
    for (int k = 0; k < 4; ++k) {
      const auto node = size_t(b.first_node + zone.node[k]);
      h += outer(nodes_.x[node] - nodes_.reference[node], zone.gradient[k]);
    }
    sum += zone.energy(0.5 * (h + transposed(h) + transposed(h) * h));
  });
  return sum;
}

double World::extent() const {
  Box around;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const double r = blocks_[i].radius;
    around.include(part_.rough_place[i] - Vector{r, r, r}), around.include(part_.rough_place[i] + Vector{r, r, r});
  }
  return norm(around.upper - around.lower);
}

double World::kinetic_energy() const {
  double sum = 0.0;
  for (int i = 0; i < block_count(); ++i) sum += kinetic_energy_of(i);
  return sum;
}

double World::kinetic_energy_of_all() const {
  std::vector<double> of_block(blocks_.size(), 0.0);
  for (int i = 0; i < block_count(); ++i) {
    if (owns(i)) of_block[size_t(i)] = kinetic_energy_of(i);
  }
  gather_by_block(of_block);
  double sum = 0.0;
  for (const double e : of_block) sum += e;
  return sum;
}

// Of a unit of two halves, what they have together is the first one's.
double World::kinetic_energy_of(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  double sum = 0.0;
  if (b.body >= 0) {
    const Body& body = bodies_[size_t(b.body)];
    for (int k = 0; k < 3; ++k)
      if (!(body.held >> k & 1)) sum += 0.5 * body.mass * body.v[k] * body.v[k];
    if ((body.held >> 3) != 7) sum += 0.5 * dot(body.momentum, body.omega);
    return sum;
  }
  for (size_t i = size_t(b.first_node); i < size_t(b.first_node + b.node_count); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double factor = nodes_.held[i] >> k & 1 ? 0.0 : solver_.deformation_inertia;
      sum += 0.5 * factor * nodes_.mass[i] * nodes_.v[i][k] * nodes_.v[i][k];
    }
  }
  const Unit unit = units_.of(block);
  if (splits_motion() && unit.block[0] == block) sum += rigid_kinetic_energy(unit);
  return sum;
}

Vector World::linear_momentum() const {
  Vector p;
  for (const Body& b : bodies_) p += b.mass * b.v;
  for (size_t i = 0; i < nodes_.x.size(); ++i) p += nodes_.mass[i] * nodes_.v[i];
  return p;
}

Vector World::angular_momentum(const Vector& about) const {
  // Velocities live half a step before positions; x - v dt/2 takes both to the same time (cross(v, v) = 0).
  Vector l;
  for (const Body& b : bodies_) l += b.momentum + b.mass * cross(b.x - about, b.v);
  for (size_t i = 0; i < nodes_.x.size(); ++i) l += nodes_.mass[i] * cross(nodes_.x[i] - about, nodes_.v[i]);
  return l;
}

double World::unbalanced_ratio() const {
  double forces = 0.0;
  for (const Chunk& chunk : chunks_.all) forces += part_.ranks ? chunk.force_sum : force_sum_of(chunk);
  if (step_sums_.unbalanced == 0.0) return 0.0;
  return forces > 0 ? step_sums_.unbalanced * double(point_count()) / forces : std::numeric_limits<double>::infinity();
}

double World::force_sum_of(const Chunk& chunk) const {
  const Family& f = contacts_.families[size_t(chunk.family)];
  double sum = 0.0;
  for (size_t i = chunk.first; i < chunk.first + chunk.count; ++i) {
    double square = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double t = f.traction[k][i] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][i]);
      square += t * t;
    }
    sum += f.area[i] * std::sqrt(square);
  }
  return sum;
}

Deepest World::deepest_of(const Chunk& chunk) const {
  const Family& f = contacts_.families[size_t(chunk.family)];
  const auto first = f.normal_jump.begin() + chunk.first, least = std::min_element(first, first + chunk.count);
  return {*least, place_of(f.point[size_t(least - f.normal_jump.begin())])};
}

size_t World::point_count() const {
  size_t count = 0;
  for (const Family& f : contacts_.families) count += f.size();
  return count;
}

double World::mass_of(int block) const { return blocks_[size_t(block)].mass; }

double World::mass() const {
  double m = 0.0;
  for (const ModelBlock& b : blocks_) m += b.mass;
  return m;
}

uint64_t World::hash(const GiveParts& parts) const {
  FnvHash hash(kOtherHashStart);
  const auto each_part = [&](const auto& array, const TakeBytes& take) {
    const auto bytes = std::as_bytes(std::span(array));
    if (parts) return parts(bytes.data(), bytes.size(), take);
    take({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
  };
  const auto add_field = [&](const Field& field, const auto& array) {
    if (field.hashed == 0) return;
    const size_t size = sizeof array[0];
    std::vector<uint8_t> rest;  // of an item that comes in two parts
    each_part(array, [&](std::span<const uint8_t> bytes) {
      if (field.hashed == size) return hash.add(bytes);
      rest.insert(rest.end(), bytes.begin(), bytes.end());
      size_t done = 0;
      for (; rest.size() - done >= size; done += size) hash.add(std::span(rest).subspan(done, field.hashed));
      rest.erase(rest.begin(), rest.begin() + long(done));
    });
  };
  WorldFields::each(*this, add_field);
  if (held_by_.members) held_by_.members->each_number([&](double x) { hash.add(std::bit_cast<std::uint64_t>(x)); });
  return hash.value();
}

}  // namespace quoin::blocks
