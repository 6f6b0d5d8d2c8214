// Results of a model.
#include "model/world_results.h"

#include <bit>
#include <limits>

#include "base/fnv_hash.h"
#include "members/members.h"
#include "model/block_layout.h"
#include "model/contact_frames.h"
#include "model/fields.h"

namespace quoin::blocks {

using namespace geometry;

namespace {

// Mean of a field over the gridpoints of a deformable block. at(n): value at its gridpoint n.
template <class At>
Vector mass_mean(const World& w, const ModelBlock& b, const At& at) {
  Vector sum;
  double mass = 0.0;
  for (int n = 0; n < b.node_count; ++n) {
    const double of_node = w.nodes.mass[size_t(b.first_node + n)];
    sum += of_node * at(n), mass += of_node;
  }
  return sum / mass;
}

}  // namespace

Vector position_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[block];
  if (b.body >= 0) return w.bodies[b.body].x;
  return mass_mean(w, b, [&](int n) { return w.nodes.x[size_t(b.first_node + n)]; });
}

Vector start_position_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  if (b.body >= 0) return w.poses.start[size_t(block)].x;
  return mass_mean(w, b, [&](int n) { return w.nodes.reference[size_t(b.first_node + n)]; });
}

Matrix orientation_of(const World& w, int block) {
  return pose(w, block).r * transposed(w.poses.start[size_t(block)].r);
}

Matrix turn_of_frame(const World& w, int block) {
  return w.frames.fixed[size_t(block)] ? Matrix{} : orientation_of(w, block);
}

Vector moved_by_now(const World& w, int block) { return position_of(w, block) - start_position_of(w, block); }

Vector moved(const World& w, int block) {
  return w.part.ranks ? w.step_sums.of_block[size_t(block)].moved : moved_by_now(w, block);
}

double turned(const World& w, int block) {
  return w.part.ranks ? w.step_sums.of_block[size_t(block)].turned : turned_by_now(w, block);
}

double turned_by_now(const World& w, int block) {
  const Matrix r = transposed(orientation_of(w, block));
  // |R - 1|^2 = 8 sin^2(angle / 2), which is accurate at small angles.
  double squares = 0.0;
  for (int k = 0; k < 3; ++k) {
    for (int c = 0; c < 3; ++c) {
      const double d = r.row[k][c] - (k == c ? 1.0 : 0.0);
      squares += d * d;
    }
  }
  return 2.0 * std::asin(std::min(1.0, std::sqrt(squares / 8.0)));
}

Vector velocity_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[block];
  if (b.body >= 0) return w.bodies[b.body].v;
  return mass_mean(w, b, [&](int n) { return gridpoint_velocity(w, block, n); });
}

Vector spin_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[block];
  return b.body >= 0 ? w.bodies[b.body].omega : Vector{};
}

Matrix frame_of(const World& w, const Point& p) {
  if (p.on_gridpoints) {
    const Matrix r = rotation_of_frame(w, p.a);
    return {{r * p.n, r * p.s, r * p.t}};
  }
  if (p.facet_a >= 0 && !w.is_small) {
    const TriangleFrame now = triangle_frame(w.nodes.x, w.contacts.facets[size_t(p.facet_a)]);
    return {{now.n, now.s, now.t}};
  }
  if (p.facet_a >= 0) return {{p.n, p.s, p.t}};
  const Matrix& r = w.bodies[size_t(w.blocks[size_t(p.a)].body)].r;
  return {{r * p.n, r * p.s, r * p.t}};
}

Vector force_on_a(const World& w, const Family& f, size_t point) {
  const Matrix frame = frame_of(w, f.point[point]);
  Vector sum;
  for (int k = 0; k < 3; ++k)
    sum += f.point[point].area * (f.traction[k][point] + (f.viscous[k].empty() ? 0.0 : f.viscous[k][point])) *
           frame.row[k];
  return sum;
}

Vector place_of(const World& w, const Point& p) { return locate(w, p, w.contacts.facets).at; }

std::vector<PlacedPoint> placed_points(const World& w, const Family& f) {
  std::vector<PlacedPoint> points;
  for (const Point& p : f.point) {
    const auto along = [&](const Vector& axis) { return array(in_space(w, p, axis)); };
    points.push_back({array(p.at), p.area, p.a, p.b, {along(p.n), along(p.s), along(p.t)}});
  }
  return points;
}

Vector corner_of(const World& w, int block, int vertex) {
  const ModelBlock& b = w.blocks[block];
  if (b.body < 0) return w.nodes.x[size_t(b.first_node) + size_t(vertex)];
  const Body& body = w.bodies[b.body];
  return body.x + body.r * w.shapes.corner[b.first_corner + size_t(vertex)];
}

size_t World::zone_count() const {
  size_t count = 0;
  for (const ModelBlock& b : blocks) count += size_t(b.zone_count);
  return count;
}

Matrix zone_stress(const World& w, int block, int z) {
  const Zone zone = zone_of(w, block, z);
  const Vector* const x = w.nodes.x.data() + w.blocks[size_t(block)].first_node;
  Matrix f = Matrix::zero();
  for (int k = 0; k < 4; ++k) f += outer(x[zone.node[k]], zone.gradient[k]);
  const bool is_fixed = w.frames.fixed[size_t(block)] != 0;
  const Matrix strain = is_fixed ? 0.5 * (f + transposed(f)) - Matrix{} : 0.5 * (transposed(f) * f - Matrix{});
  const Matrix second = 2 * zone.mu * strain + zone.lambda * trace(strain) * Matrix{};
  if (is_fixed) return second;
  return 1 / determinant(f) * (f * second * transposed(f));
}

double strain_energy(const World& w) {
  double sum = 0.0;
  each_zone(w, [&](const ModelBlock& b, const Zone& zone) {
    Matrix h = Matrix::zero();
    for (int k = 0; k < 4; ++k) {
      const auto node = size_t(b.first_node + zone.node[k]);
      h += outer(w.nodes.x[node] - w.nodes.reference[node], zone.gradient[k]);
    }
    const bool is_fixed = w.frames.fixed[size_t(&b - w.blocks.data())] != 0;
    sum += zone.energy(0.5 * (h + transposed(h) + (is_fixed ? Matrix::zero() : transposed(h) * h)));
  });
  return sum;
}

double extent_of(const World& w) {
  Box around;
  for (size_t i = 0; i < w.blocks.size(); ++i) {
    const double r = w.blocks[i].radius;
    around.include(w.part.rough_place[i] - Vector{r, r, r}), around.include(w.part.rough_place[i] + Vector{r, r, r});
  }
  return norm(around.upper - around.lower);
}

double kinetic_energy_of_all(const World& w) {
  std::vector<double> of_block(w.blocks.size(), 0.0);
  for (int i = 0; i < w.block_count(); ++i) {
    if (w.part.owns(i)) of_block[size_t(i)] = kinetic_energy_of(w, i);
  }
  w.part.gather_by_block(of_block);
  double sum = 0.0;
  for (const double e : of_block) sum += e;
  return sum;
}

// The energy that two halves of a unit share counts for the first half.
double kinetic_energy_of(const World& w, int block) {
  const ModelBlock& b = w.blocks[size_t(block)];
  double sum = 0.0;
  if (b.body >= 0) {
    const Body& body = w.bodies[size_t(b.body)];
    for (int k = 0; k < 3; ++k)
      if (!(body.held >> k & 1)) sum += 0.5 * body.mass * body.v[k] * body.v[k];
    if ((body.held >> 3) != 7) sum += 0.5 * dot(body.momentum, body.omega);
    return sum;
  }
  for (size_t i = size_t(b.first_node); i < size_t(b.first_node + b.node_count); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double factor = w.nodes.held[i] >> k & 1 ? 0.0 : w.solver.deformation_inertia;
      sum += 0.5 * factor * w.nodes.mass[i] * w.nodes.v[i][k] * w.nodes.v[i][k];
    }
  }
  const Unit unit = w.units.of(block);
  if (splits_motion(w) && unit.block[0] == block) sum += rigid_kinetic_energy(w, unit);
  return sum;
}

double unbalanced_ratio(const World& w) {
  double forces = 0.0;
  for (const Chunk& chunk : w.chunks.all) forces += w.part.ranks ? chunk.force_sum : force_sum_of(w, chunk);
  double unbalanced = w.step_sums.unbalanced, count = double(w.point_count());
  if (const members::Members* const members = w.held_by.members.get()) {
    if (!(members->unbalanced() <= unbalanced)) unbalanced = members->unbalanced();
    for (const members::Node& node : members->nodes()) forces += norm(node.force), count += 1.0;
  }
  if (unbalanced == 0.0) return 0.0;
  return forces > 0 ? unbalanced * count / forces : std::numeric_limits<double>::infinity();
}

double force_sum_of(const World& w, const Chunk& chunk) {
  const Family& f = w.contacts.families[size_t(chunk.family)];
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

Deepest deepest_of_chunk(const World& w, int chunk) {
  const Chunk& c = w.chunks.all[size_t(chunk)];
  return w.part.ranks ? c.deepest : deepest_of(w, c);
}

Deepest deepest_of(const World& w, const Chunk& chunk) {
  const Family& f = w.contacts.families[size_t(chunk.family)];
  const auto first = f.normal_jump.begin() + chunk.first, least = std::min_element(first, first + chunk.count);
  return {*least, place_of(w, f.point[size_t(least - f.normal_jump.begin())])};
}

size_t World::point_count() const {
  size_t count = 0;
  for (const Family& f : contacts.families) count += f.size();
  return count;
}

double whole_mass(const World& w) {
  double m = 0.0;
  for (const ModelBlock& b : w.blocks) m += b.mass;
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
    std::vector<uint8_t> rest;  // second part of an item that arrives in two
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
