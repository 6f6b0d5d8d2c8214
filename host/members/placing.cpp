#include "members/placing.h"

#include <fmt/format.h>

#include "base/error.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

namespace quoin::members {

int Placing::add(int block, const Vector& at, bool turns) {
  Node& node = nodes.emplace_back();
  node.block = block, node.turns = turns;
  node.start = node.x = at;
  return static_cast<int>(nodes.size()) - 1;
}

const geometry::ConvexPolyhedron& Placing::shape_of(int block) const {
  return assembly.shapes[static_cast<std::size_t>(assembly.blocks[static_cast<std::size_t>(block)].shape)];
}

double Placing::allowed_off(int block) const {
  constexpr double kOffBlock = 1e-3;  // of the block's largest extent: scenes have rounded coordinates
  return kOffBlock * geometry::longest_extent(shape_of(block).vertices);
}

int Placing::block_of(const MemberEnd& end) const {
  const Vector at = geometry::vector(end.point);
  const auto off = [&](int block) {
    return distance_from(assembly, assembly.blocks[static_cast<std::size_t>(block)], at);
  };
  std::vector<int> candidates;
  if (end.block.empty()) {
    for (std::size_t b = 0; b < assembly.blocks.size(); ++b) candidates.push_back(static_cast<int>(b));
  } else {
    candidates = blocks::find_blocks(assembly, end.block, end.source.text);
  }
  double least = 1e300;
  int nearest = -1;
  std::vector<int> has;
  for (const int block : candidates) {
    const double outside = off(block);
    if (outside < least) least = outside, nearest = block;
    if (outside <= allowed_off(block)) has.push_back(block);
  }
  if (has.empty())
    throw Error(Exit::bad_input,
                fmt::format("{}: the end at {} is in the air: {} {} is {:.3g} m away at least; allowed: a point in a "
                            "block or on its face",
                            end.source.text, geometry::place(at), end.block.empty() ? "the nearest block," : "block",
                            label(assembly, nearest), least));
  // A point on a common face belongs to both blocks, so neither can be chosen.
  for (const int block : has) {
    if (block == nearest || off(block) > least + 1e-9) continue;
    throw Error(Exit::bad_input, fmt::format("{}: the end at {} is where blocks {} and {} meet; {}", end.source.text,
                                             geometry::place(at), label(assembly, nearest), label(assembly, block),
                                             end.block.empty() ? "move it into one of them, or name that as block"
                                                               : "move it into one of them"));
  }
  return nearest;
}

int Placing::block_at(const Vector& point, double* off) const {
  int nearest = -1;
  *off = 1e300;
  for (std::size_t b = 0; b < assembly.blocks.size(); ++b) {
    const double outside = distance_from(assembly, assembly.blocks[b], point);
    if (outside < *off - 1e-9) *off = outside, nearest = static_cast<int>(b);
  }
  return nearest >= 0 && *off <= allowed_off(nearest) ? nearest : -1;
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

}  // namespace quoin::members
