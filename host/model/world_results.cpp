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
  return mass_mean(b, node_mass_, node_x_);
}

Vector World::start_position(int block) const {
  const ModelBlock& b = blocks_[size_t(block)];
  if (b.body >= 0) return start_[size_t(block)].x;
  return mass_mean(b, node_mass_, node_reference_);
}

Matrix World::orientation(int block) const {
  Vector x;
  Matrix r;
  pose(block, x, r);
  return r * transposed(start_[size_t(block)].r);
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
  return mass_mean(b, node_mass_, node_v_);
}

Vector World::angular_velocity(int block) const {
  const ModelBlock& b = blocks_[block];
  return b.body >= 0 ? bodies_[b.body].omega : Vector{};
}

Vector World::contact_force(int block) const { return block_contact_force_[block]; }

Matrix World::frame_of(const Point& p) const {
  if (p.on_gridpoints) {
    const Matrix r = rotation_of_frame(p.a);
    return {{r * p.n, r * p.s, r * p.t}};
  }
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

double World::extent() const {
  Box around;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const double r = blocks_[i].radius;
    around.include(rough_place_[i] - Vector{r, r, r}), around.include(rough_place_[i] + Vector{r, r, r});
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
      const double factor = node_held_[i] >> k & 1 ? 0.0 : solver_.deformation_inertia;
      sum += 0.5 * factor * node_mass_[i] * node_v_[i][k] * node_v_[i][k];
    }
  }
  const Unit unit = unit_of(block);
  if (splits_motion() && unit.block[0] == block) sum += rigid_kinetic_energy(unit);
  return sum;
}

Vector World::linear_momentum() const {
  Vector p;
  for (const Body& b : bodies_) p += b.mass * b.v;
  for (size_t i = 0; i < node_x_.size(); ++i) p += node_mass_[i] * node_v_[i];
  return p;
}

Vector World::angular_momentum(const Vector& about) const {
  // Velocities live half a step before positions; x - v dt/2 takes both to the same time (cross(v, v) = 0).
  Vector l;
  for (const Body& b : bodies_) l += b.momentum + b.mass * cross(b.x - about, b.v);
  for (size_t i = 0; i < node_x_.size(); ++i) l += node_mass_[i] * cross(node_x_[i] - about, node_v_[i]);
  return l;
}

double World::unbalanced_ratio() const {
  double forces = 0.0;
  for (const Chunk& chunk : chunks_) forces += ranks_ ? chunk.force_sum : force_sum_of(chunk);
  if (unbalanced_ == 0.0) return 0.0;
  return forces > 0 ? unbalanced_ * double(point_count()) / forces : std::numeric_limits<double>::infinity();
}

double World::force_sum_of(const Chunk& chunk) const {
  const Family& f = families_[size_t(chunk.family)];
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
  const Family& f = families_[size_t(chunk.family)];
  const auto first = f.normal_jump.begin() + chunk.first, least = std::min_element(first, first + chunk.count);
  return {*least, place_of(f.point[size_t(least - f.normal_jump.begin())])};
}

size_t World::point_count() const {
  size_t count = 0;
  for (const Family& f : families_) count += f.size();
  return count;
}

double World::mass_of(int block) const { return block_mass_[size_t(block)]; }

double World::mass() const {
  double m = 0.0;
  for (const double of_block : block_mass_) m += of_block;
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
  if (members_) members_->each_number([&](double x) { hash.add(std::bit_cast<std::uint64_t>(x)); });
  return hash.value();
}

}  // namespace quoin::blocks
