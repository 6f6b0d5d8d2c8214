// Faces on springs: their points, and their forces in a step.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "members/spring.h"
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

Bed placed(const SpringSpec& spec, Placing& placing) {
  const blocks::Assembly& assembly = placing.assembly;
  Bed bed;
  bed.name = spec.name;
  for (const int index : blocks::find_blocks(assembly, spec.block, spec.source.text)) {
    const geometry::ConvexPolyhedron& shape = placing.shape_of(index);
    const auto face = static_cast<std::size_t>(
        blocks::face_towards(assembly, index, geometry::vector(spec.normal), spec.source.text));
    const Vector out = matrix(assembly.blocks[static_cast<std::size_t>(index)].orientation) * shape.normals[face];
    each_triangle(assembly, index, face, [&](const std::array<Vector, 3>& triangle) {
      each_point(triangle, spec.divisions, [&](const Vector& at, double area) {
        bed.points.push_back({placing.add(index, at), area, out, law_of(spec, area), {}});
      });
    });
    bed.area += geometry::face_area(shape, static_cast<int>(face));
  }
  return bed;
}

std::vector<std::string> column_names(const SpringSpec& spec) {
  std::vector<std::string> names;
  for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("spring_{}_{}_N", spec.name, axis));
  return names;
}

void Bed::pull(std::vector<Node>& nodes, const Surroundings& step) {
  Vector before, after;
  for (SpringPoint& p : points) {
    Node& node = nodes[static_cast<std::size_t>(p.node)];
    before += p.state.force;
    p.state.follow(p.law, p.out, node.x - node.start - step.ground, step.dt);
    after += p.state.force;
    node.force += p.state.force;
  }
  ground_work += 0.5 * dot(before + after, step.ground_way);
}

Work Bed::work() const {
  Work sum{0.0, 0.0, ground_work};
  for (const SpringPoint& p : points) sum += {p.state.stored, p.state.dissipated, 0.0};
  return sum;
}

std::vector<double> Bed::columns() const {
  const Vector sum = force();
  return {sum.x, sum.y, sum.z};
}

bool Bed::has_dashpots() const {
  return std::ranges::any_of(
      points, [](const SpringPoint& p) { return p.law.normal_dashpot > 0.0 || p.law.shear_dashpot > 0.0; });
}

}  // namespace quoin::members
