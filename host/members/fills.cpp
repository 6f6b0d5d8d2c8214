// Soil on faces: its points, and its forces in a step.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "geometry/broad_phase.h"
#include "members/fill.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

namespace quoin::members {

namespace {

// Distance in front of a face at which another block covers it, as a share of the block's least extent: scenes have
// rounded coordinates.
constexpr double kInFront = 2e-3;

double in_front(const blocks::Assembly& assembly, std::size_t block) {
  return kInFront * geometry::least_extent(assembly.shapes[static_cast<std::size_t>(assembly.blocks[block].shape)]);
}

// Other blocks, by block, that may cover faces.
std::vector<std::vector<int>> neighbours_of(const blocks::Assembly& assembly) {
  std::vector<geometry::Box> boxes(assembly.blocks.size());
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    const blocks::Block& block = assembly.blocks[b];
    const double off = in_front(assembly, b);
    for (const Vector& vertex : assembly.shapes[static_cast<std::size_t>(block.shape)].vertices) {
      const Vector at = block.position + matrix(block.orientation) * vertex;
      boxes[b].include(at - Vector{off, off, off}), boxes[b].include(at + Vector{off, off, off});
    }
  }
  std::vector<std::vector<int>> near(boxes.size());
  for (const auto& [a, b] : geometry::overlapping_pairs(boxes))
    near[static_cast<std::size_t>(a)].push_back(b), near[static_cast<std::size_t>(b)].push_back(a);
  return near;
}

// Whether one of these blocks covers the face at a point. Points on the border are tested slightly inside.
bool is_covered(const blocks::Assembly& assembly, double off, const std::vector<int>& others, const Vector& at,
                const Vector& middle, const Vector& out) {
  const Vector beside = at + off * out + std::min(1.0, 4.0 * off / norm(middle - at)) * (middle - at);
  return std::ranges::any_of(others, [&](int b) {
    return distance_from(assembly, assembly.blocks[static_cast<std::size_t>(b)], beside) < 0.0;
  });
}

// Visits the part of a triangle below the surface of the soil, as triangles: visit(triangle).
void each_triangle_below(const std::array<Vector, 3>& triangle, const Vector& surface, const Vector& up,
                         const std::function<void(const std::array<Vector, 3>&)>& visit) {
  std::vector<Vector> part;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector &a = triangle[k], &b = triangle[(k + 1) % 3];
    const double depth_a = dot(surface - a, up), depth_b = dot(surface - b, up);
    if (depth_a >= 0.0) part.push_back(a);
    if ((depth_a > 0.0 && depth_b < 0.0) || (depth_a < 0.0 && depth_b > 0.0))
      part.push_back(a + depth_a / (depth_a - depth_b) * (b - a));
  }
  for (std::size_t k = 1; k + 1 < part.size(); ++k) visit({part[0], part[k], part[k + 1]});
}

// Blocks of this name, or of a group such as an arch, whose blocks are NAME/0 and so on, without its fixed abutments.
std::vector<int> blocks_of(const FillSpec& spec, const blocks::Assembly& assembly) {
  std::vector<int> found;
  for (std::size_t b = 0; b < assembly.blocks.size(); ++b)
    if (!assembly.blocks[b].fixed && assembly.blocks[b].name.starts_with(spec.block + "/"))
      found.push_back(static_cast<int>(b));
  return found.empty() ? blocks::find_blocks(assembly, spec.block, spec.source.text) : found;
}

FillLaw law_of(const FillSpec& spec, const Vector& at, double area, const Vector& out) {
  const Vector up = normalized(geometry::vector(spec.up));
  FillLaw law;
  const double lift = dot(out, up);
  const Vector level = out - lift * up;
  law.up = up, law.upright = area * lift, law.level = area * norm(level);
  law.out = norm(level) > 0.0 ? normalized(level) : Vector{};
  law.vertical = spec.surcharge + spec.unit_weight * std::max(0.0, dot(geometry::vector(spec.surface) - at, up));
  law.at_rest = spec.at_rest, law.active = spec.active, law.passive = spec.passive;
  law.stiffness = spec.stiffness;
  return law;
}

}  // namespace

Fill placed(const FillSpec& spec, Placing& placing) {
  const blocks::Assembly& assembly = placing.assembly;
  // Least cosine between a face's normal and `towards`; it excludes fronts and intrados of vaults.
  constexpr double kTowards = 0.05;
  Fill fill;
  fill.name = spec.name;
  const Vector towards = normalized(geometry::vector(spec.towards)), up = normalized(geometry::vector(spec.up));
  const std::vector<std::vector<int>> near = neighbours_of(assembly);
  for (const int index : blocks_of(spec, assembly)) {
    const auto own = static_cast<std::size_t>(index);
    const blocks::Block& block = assembly.blocks[own];
    const geometry::ConvexPolyhedron& shape = assembly.shapes[static_cast<std::size_t>(block.shape)];
    for (std::size_t f = 0; f < shape.faces.size(); ++f) {
      const Vector out = matrix(block.orientation) * shape.normals[f];
      if (dot(out, towards) < kTowards) continue;
      const auto fill_in = [&](const std::array<Vector, 3>& below) {
        const Vector middle = (1.0 / 3.0) * (below[0] + below[1] + below[2]);
        each_point(below, spec.divisions, [&](const Vector& at, double area) {
          if (!(area > 0.0) || is_covered(assembly, in_front(assembly, own), near[own], at, middle, out)) return;
          fill.points.push_back({placing.add(index, at), law_of(spec, at, area, out), {}});
          fill.area += area;
        });
      };
      each_triangle(assembly, index, f, [&](const std::array<Vector, 3>& triangle) {
        each_triangle_below(triangle, geometry::vector(spec.surface), up, fill_in);
      });
    }
  }
  if (fill.points.empty())
    throw Error(Exit::bad_input,
                fmt::format("{}: fill '{}' reaches no free face of '{}' towards ({:g}, {:g}, {:g}) below {}; give "
                            "towards, or a surface above them",
                            spec.source.text, spec.name, spec.block, towards.x, towards.y, towards.z,
                            geometry::place(geometry::vector(spec.surface))));
  return fill;
}

std::vector<std::string> column_names(const FillSpec& spec) {
  std::vector<std::string> names;
  for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("fill_{}_{}_N", spec.name, axis));
  return names;
}

void Fill::pull(std::vector<Node>& nodes, const Surroundings& step) {
  for (FillPoint& p : points) {
    Node& node = nodes[static_cast<std::size_t>(p.node)];
    p.state.follow(p.law, step.jack, node.x - node.start);
    node.force += p.state.force;
  }
}

Work Fill::work() const {
  Work sum;
  for (const FillPoint& p : points) sum += {p.state.stored, p.state.dissipated, p.state.outside};
  return sum;
}

std::vector<double> Fill::columns() const {
  const Vector sum = force();
  return {sum.x, sum.y, sum.z};
}

}  // namespace quoin::members
