// Faces on springs: where their points are, and what they do in a step.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "members/members.h"
#include "scene/generate_blocks.h"

namespace quoin::members {

namespace {

SpringLaw law_of(const SpringSpec& spec, double area) {
  SpringLaw law;
  law.normal = area * spec.normal_stiffness, law.shear = area * spec.shear_stiffness;
  law.normal_dashpot = area * spec.normal_dashpot, law.shear_dashpot = area * spec.shear_dashpot;
  if (spec.friction_angle < 90.0) law.friction = std::tan(spec.friction_angle * std::numbers::pi / 180.0);
  law.tension = spec.tension;
  return law;
}

}  // namespace

void Members::add_bed(const SpringSpec& spec, const blocks::Assembly& assembly) {
  Bed bed{spec.name, points_.size(), 0, 0.0};
  for (const int index : blocks::find_blocks(assembly, spec.block, spec.source.text)) {
    const blocks::Block& block = assembly.blocks[static_cast<std::size_t>(index)];
    const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
    const geometry::Matrix turned = matrix(block.orientation);
    std::size_t face = 0;
    const auto towards = [&](std::size_t f) { return dot(turned * shape.normals[f], geometry::vector(spec.normal)); };
    for (std::size_t f = 1; f < shape.faces.size(); ++f) {
      if (towards(f) > towards(face)) face = f;
    }
    const auto corner = [&](std::size_t k) {
      return block.position + turned * shape.vertices[static_cast<std::size_t>(shape.faces[face][k])];
    };
    for (std::size_t k = 1; k + 1 < shape.faces[face].size(); ++k)
      add_points(spec, {corner(0), corner(k), corner(k + 1)}, index, turned * shape.normals[face]);
    bed.area += geometry::face_area(shape, static_cast<int>(face));
  }
  bed.end = points_.size();
  beds_.push_back(bed);
}

// A triangle in divisions^2 congruent ones, each with three points in the middle of its edges. Exact for quadratics:
// the stiffness against turning is that of the face.
void Members::add_points(const SpringSpec& spec, const std::array<Vector, 3>& triangle, int block, const Vector& out) {
  const double n = spec.divisions;
  const Vector u = (triangle[1] - triangle[0]) / n, v = (triangle[2] - triangle[0]) / n;
  const SpringLaw law = law_of(spec, norm(cross(u, v)) / 6.0);
  const auto add = [&](const Vector& at) {
    Node node;
    node.block = block;
    node.start = node.x = at;
    points_.push_back({static_cast<int>(nodes_.size()), out, law, {}});
    nodes_.push_back(node);
  };
  for (int i = 0; i < spec.divisions; ++i) {
    for (int j = 0; i + j < spec.divisions; ++j) {
      const Vector corner = triangle[0] + static_cast<double>(i) * u + static_cast<double>(j) * v;
      for (const Vector& middle : {0.5 * u, 0.5 * v, 0.5 * (u + v)}) add(corner + middle);
      if (i + j + 1 == spec.divisions) continue;
      for (const Vector& middle : {0.5 * u, 0.5 * v, 0.5 * (u + v)}) add(corner + u + v - middle);
    }
  }
}

void Members::pull_beds(const Vector& ground_way, double dt) {
  if (beds_.empty()) return;
  ground_ += ground_way;
  Vector before, after;
  for (SpringPoint& p : points_) {
    Node& node = nodes_[static_cast<std::size_t>(p.node)];
    before += p.state.force;
    p.state.follow(p.law, p.out, node.x - node.start - ground_, dt);
    after += p.state.force;
    node.force += p.state.force;
  }
  ground_work_ += 0.5 * dot(before + after, ground_way);
}

Vector Members::force_of(const Bed& bed) const {
  Vector sum;
  for (std::size_t i = bed.first; i < bed.end; ++i) sum += points_[i].state.force;
  return sum;
}

bool Members::has_dashpots() const {
  return std::any_of(points_.begin(), points_.end(),
                     [](const SpringPoint& p) { return p.law.normal_dashpot > 0.0 || p.law.shear_dashpot > 0.0; });
}

}  // namespace quoin::members
