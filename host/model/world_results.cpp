// Results of a model.
#include <bit>
#include <cstring>
#include <limits>

#include "base/fnv_hash.h"
#include "members/members.h"
#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/fields.h"
#include "model/world.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Mean of a field over the gridpoints of a deformable block.
template <class Masses, class Field>
Vector mass_mean(const ModelBlock& b, const Masses& node_mass, const Field& field) {
  Vector sum;
  double mass = 0.0;
  for (int i = b.first_node; i < b.first_node + b.node_count; ++i) sum += node_mass[i] * field[i], mass += node_mass[i];
  return sum / mass;
}

}  // namespace

Vector World::position(int block) const {
  const ModelBlock& b = blocks[block];
  if (b.body >= 0) return bodies[b.body].x;
  return mass_mean(b, nodes.mass, nodes.x);
}

Vector World::start_position(int block) const {
  const ModelBlock& b = blocks[size_t(block)];
  if (b.body >= 0) return poses.start[size_t(block)].x;
  return mass_mean(b, nodes.mass, nodes.reference);
}

Matrix World::orientation(int block) const { return pose(*this, block).r * transposed(poses.start[size_t(block)].r); }

double World::moved(int block) const {
  return part.ranks ? step_sums.of_block[size_t(block)].moved : moved_by_now(block);
}

double World::turned(int block) const {
  return part.ranks ? step_sums.of_block[size_t(block)].turned : turned_by_now(block);
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
  const ModelBlock& b = blocks[block];
  if (b.body >= 0) return bodies[b.body].v;
  return mass_mean(b, nodes.mass, nodes.v);
}

Vector World::angular_velocity(int block) const {
  const ModelBlock& b = blocks[block];
  return b.body >= 0 ? bodies[b.body].omega : Vector{};
}

Vector World::contact_force(int block) const { return step_sums.contact_force[block]; }

Matrix World::frame_of(const Point& p) const {
  if (p.on_gridpoints) {
    const Matrix r = rotation_of_frame(*this, p.a);
    return {{r * p.n, r * p.s, r * p.t}};
  }
  if (p.facet_a >= 0 && !is_small) {
    Point now = p;
    Facet facet = contacts.facets[size_t(p.facet_a)];
    refresh_facet_frame(*this, now, facet);
    return {{now.n, now.s, now.t}};
  }
  if (p.facet_a >= 0) return {{p.n, p.s, p.t}};
  const Matrix& r = bodies[size_t(blocks[size_t(p.a)].body)].r;
  return {{r * p.n, r * p.s, r * p.t}};
}

Vector World::place_of(const Point& p) const { return locate(*this, p, contacts.facets).at; }

Vector World::corner(int block, int vertex) const {
  const ModelBlock& b = blocks[block];
  if (b.body < 0) return nodes.x[size_t(b.first_node) + size_t(vertex)];
  const Body& body = bodies[b.body];
  return body.x + body.r * shapes.corner[b.first_corner + size_t(vertex)];
}

std::vector<std::vector<Vector>> World::faces(int block) const {
  const ModelBlock& b = blocks[size_t(block)];
  std::vector<std::vector<Vector>> result;
  if (b.body >= 0) {
    for (const auto& face : b.shape->faces) {
      auto& corners = result.emplace_back();
      for (int v : face) corners.push_back(corner(block, v));
    }
    return result;
  }
  for (const auto& t : b.surface) result.push_back({nodes.x[t.node[0]], nodes.x[t.node[1]], nodes.x[t.node[2]]});
  return result;
}

size_t World::zone_count() const {
  size_t count = 0;
  for (const ModelBlock& b : blocks) count += size_t(b.zone_count);
  return count;
}

Matrix World::zone_stress(int block, int z) const {
  const Zone zone = this->zone(block, z);
  const Vector* const x = nodes.x.data() + blocks[size_t(block)].first_node;
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
      h += outer(nodes.x[node] - nodes.reference[node], zone.gradient[k]);
    }
    sum += zone.energy(0.5 * (h + transposed(h) + transposed(h) * h));
  });
  return sum;
}

double World::extent() const {
  Box around;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const double r = blocks[i].radius;
    around.include(part.rough_place[i] - Vector{r, r, r}), around.include(part.rough_place[i] + Vector{r, r, r});
  }
  return norm(around.upper - around.lower);
}

double World::kinetic_energy() const {
  double sum = 0.0;
  for (int i = 0; i < block_count(); ++i) sum += kinetic_energy_of(i);
  return sum;
}

double World::kinetic_energy_of_all() const {
  std::vector<double> of_block(blocks.size(), 0.0);
  for (int i = 0; i < block_count(); ++i) {
    if (part.owns(i)) of_block[size_t(i)] = kinetic_energy_of(i);
  }
  part.gather_by_block(of_block);
  double sum = 0.0;
  for (const double e : of_block) sum += e;
  return sum;
}

// The energy that two halves of a unit share counts for the first one.
double World::kinetic_energy_of(int block) const {
  const ModelBlock& b = blocks[size_t(block)];
  double sum = 0.0;
  if (b.body >= 0) {
    const Body& body = bodies[size_t(b.body)];
    for (int k = 0; k < 3; ++k)
      if (!(body.held >> k & 1)) sum += 0.5 * body.mass * body.v[k] * body.v[k];
    if ((body.held >> 3) != 7) sum += 0.5 * dot(body.momentum, body.omega);
    return sum;
  }
  for (size_t i = size_t(b.first_node); i < size_t(b.first_node + b.node_count); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double factor = nodes.held[i] >> k & 1 ? 0.0 : solver.deformation_inertia;
      sum += 0.5 * factor * nodes.mass[i] * nodes.v[i][k] * nodes.v[i][k];
    }
  }
  const Unit unit = units.of(block);
  if (splits_motion(solver) && unit.block[0] == block) sum += rigid_kinetic_energy(*this, unit);
  return sum;
}

Vector World::linear_momentum() const {
  Vector p;
  for (const Body& b : bodies) p += b.mass * b.v;
  for (size_t i = 0; i < nodes.x.size(); ++i) p += nodes.mass[i] * nodes.v[i];
  return p;
}

Vector World::angular_momentum(const Vector& about) const {
  // Velocities live half a step before positions; x - v dt/2 takes both to the same time (cross(v, v) = 0).
  Vector l;
  for (const Body& b : bodies) l += b.momentum + b.mass * cross(b.x - about, b.v);
  for (size_t i = 0; i < nodes.x.size(); ++i) l += nodes.mass[i] * cross(nodes.x[i] - about, nodes.v[i]);
  return l;
}

double World::unbalanced_ratio() const {
  double forces = 0.0;
  for (const Chunk& chunk : chunks.all) forces += part.ranks ? chunk.force_sum : force_sum_of(chunk);
  if (step_sums.unbalanced == 0.0) return 0.0;
  return forces > 0 ? step_sums.unbalanced * double(point_count()) / forces : std::numeric_limits<double>::infinity();
}

double World::force_sum_of(const Chunk& chunk) const {
  const Family& f = contacts.families[size_t(chunk.family)];
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

Deepest World::deepest_of_chunk(int chunk) const {
  const Chunk& c = chunks.all[size_t(chunk)];
  return part.ranks ? c.deepest : deepest_of(c);
}

Deepest World::deepest_of(const Chunk& chunk) const {
  const Family& f = contacts.families[size_t(chunk.family)];
  const auto first = f.normal_jump.begin() + chunk.first, least = std::min_element(first, first + chunk.count);
  return {*least, place_of(f.point[size_t(least - f.normal_jump.begin())])};
}

size_t World::point_count() const {
  size_t count = 0;
  for (const Family& f : contacts.families) count += f.size();
  return count;
}

double World::mass_of(int block) const { return blocks[size_t(block)].mass; }

double World::mass() const {
  double m = 0.0;
  for (const ModelBlock& b : blocks) m += b.mass;
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
    std::vector<uint8_t> rest;  // second part of an item that comes in two
    each_part(array, [&](std::span<const uint8_t> bytes) {
      if (field.hashed == size) return hash.add(bytes);
      rest.insert(rest.end(), bytes.begin(), bytes.end());
      size_t done = 0;
      for (; rest.size() - done >= size; done += size) hash.add(std::span(rest).subspan(done, field.hashed));
      rest.erase(rest.begin(), rest.begin() + long(done));
    });
  };
  WorldFields::each(*this, add_field);
  if (held_by.members) held_by.members->each_number([&](double x) { hash.add(std::bit_cast<std::uint64_t>(x)); });
  return hash.value();
}

}  // namespace quoin::blocks
