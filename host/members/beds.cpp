// Faces on springs: their points, and their forces in a step.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "members/members.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

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
    const auto face = static_cast<std::size_t>(
        blocks::face_towards(assembly, index, geometry::vector(spec.normal), spec.source.text));
    const Vector out = matrix(block.orientation) * shape.normals[face];
    each_triangle(assembly, index, face, [&](const std::array<Vector, 3>& triangle) {
      each_point(triangle, spec.divisions, [&](const Vector& at, double area) {
        points_.push_back({static_cast<int>(nodes_.size()), area, out, law_of(spec, area), {}});
        Node& node = nodes_.emplace_back();
        node.block = index;
        node.start = node.x = at;
      });
    });
    bed.area += geometry::face_area(shape, static_cast<int>(face));
  }
  bed.end = points_.size();
  beds_.push_back(bed);
}

void each_triangle(const blocks::Assembly& assembly, int block, std::size_t face,
                   const std::function<void(const std::array<Vector, 3>&)>& visit) {
  const blocks::Block& b = assembly.blocks[static_cast<std::size_t>(block)];
  const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(b.shape)];
  const geometry::Matrix turned = matrix(b.orientation);
  const auto corner = [&](std::size_t k) {
    return b.position + turned * shape.vertices[static_cast<std::size_t>(shape.faces[face][k])];
  };
  for (std::size_t k = 1; k + 1 < shape.faces[face].size(); ++k) visit({corner(0), corner(k), corner(k + 1)});
}

void each_point(const std::array<Vector, 3>& triangle, int divisions,
                const std::function<void(const Vector&, double)>& visit) {
  const double n = divisions;
  const Vector u = (triangle[1] - triangle[0]) / n, v = (triangle[2] - triangle[0]) / n;
  const double area = norm(cross(u, v)) / 6.0;
  for (int i = 0; i < divisions; ++i) {
    for (int j = 0; i + j < divisions; ++j) {
      const Vector corner = triangle[0] + static_cast<double>(i) * u + static_cast<double>(j) * v;
      for (const Vector& middle : {0.5 * u, 0.5 * v, 0.5 * (u + v)}) visit(corner + middle, area);
      if (i + j + 1 == divisions) continue;
      for (const Vector& middle : {0.5 * u, 0.5 * v, 0.5 * (u + v)}) visit(corner + u + v - middle, area);
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
