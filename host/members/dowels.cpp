// Dowels: the blocks that they join, and their forces in a step.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "members/members.h"
#include "scene/load_place.h"

namespace quoin::members {

void Members::add_dowel(const DowelSpec& spec, const blocks::Assembly& assembly) {
  // Distance of the test points on both sides of the joint, as a share of the least extent of a block there. Length in
  // drawings, as one of the longest.
  constexpr double kBeside = 5e-3, kDrawn = 0.3;
  Dowel dowel;
  dowel.name = spec.name, dowel.along = normalized(geometry::vector(spec.direction));
  dowel.law = {spec.axial_stiffness, spec.shear_stiffness, spec.yield_force, spec.yield_shear};
  const Vector at = geometry::vector(spec.point);
  double off = 0.0;
  const int nearest = block_at(at, assembly, &off);
  if (nearest < 0)
    throw Error(Exit::bad_input, fmt::format("{}: dowel '{}' at {} is in the air, {:.3g} m off the nearest block; "
                                             "allowed: a point on a joint",
                                             spec.source.text, spec.name, geometry::place(at), off));
  const auto shape_of = [&](std::size_t b) -> const geometry::ConvexPolyhedron& {
    return assembly.shapes[static_cast<std::size_t>(assembly.blocks[b].shape)];
  };
  dowel.drawn_length = kDrawn * geometry::longest_extent(shape_of(static_cast<std::size_t>(nearest)).vertices);
  double thinnest = dowel.drawn_length;
  for (std::size_t b = 0; b < assembly.blocks.size(); ++b) {
    if (distance_from(assembly, assembly.blocks[b], at) <= allowed_off(assembly, static_cast<int>(b)))
      thinnest = std::min(thinnest, geometry::least_extent(shape_of(b)));
  }
  int block[2] = {-1, -1};
  for (const int side : {0, 1}) {
    const Vector beside = at + ((side == 0 ? -1.0 : 1.0) * kBeside * thinnest) * dowel.along;
    block[side] = block_at(beside, assembly, &off);
    Node& node = nodes_.emplace_back();
    node.block = block[side], node.turns = side == 0;
    node.start = node.x = at;
  }
  if (block[0] < 0 || block[1] < 0 || block[0] == block[1])
    throw Error(
        Exit::bad_input,
        fmt::format("{}: dowel '{}' at {} crosses no joint along ({:.3g}, {:.3g}, {:.3g}): {}; allowed: a "
                    "point on a joint, and a direction through it",
                    spec.source.text, spec.name, geometry::place(at), dowel.along.x, dowel.along.y, dowel.along.z,
                    block[0] == block[1] && block[0] >= 0
                        ? fmt::format("both sides are in block {}", label(assembly, block[0]))
                        : "one side is in the air"));
  dowel.second = static_cast<int>(nodes_.size()) - 1, dowel.first = dowel.second - 1;
  dowels_.push_back(dowel);
}

// Forces in the frame of the first block, with which the bar turns. The couple of shear and slip is neglected.
void Members::pull_dowels() {
  for (Dowel& dowel : dowels_) {
    Node &first = nodes_[static_cast<std::size_t>(dowel.first)],
         &second = nodes_[static_cast<std::size_t>(dowel.second)];
    dowel.state.follow(dowel.law, dowel.along, transposed_times(first.turn, second.x - first.x));
    const Vector force = first.turn * (dowel.state.force * dowel.along + dowel.state.shear);
    first.force += force, second.force -= force;
  }
}

}  // namespace quoin::members
