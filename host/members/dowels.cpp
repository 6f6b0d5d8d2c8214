// Dowels: the blocks that they join, and their forces in a step.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "members/dowel.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

namespace quoin::members {

Dowel placed(const DowelSpec& spec, Placing& placing) {
  const blocks::Assembly& assembly = placing.assembly;
  // Distance of the test points on both sides of the joint, as a share of the least extent of a block there. Length in
  // drawings, as one of the longest.
  constexpr double kBeside = 5e-3, kDrawn = 0.3;
  Dowel dowel;
  dowel.name = spec.name, dowel.along = normalized(geometry::vector(spec.direction));
  dowel.law = {spec.axial_stiffness, spec.shear_stiffness, spec.yield_force, spec.yield_shear};
  const Vector at = geometry::vector(spec.point);
  double off = 0.0;
  const int nearest = placing.block_at(at, &off);
  if (nearest < 0)
    throw Error(Exit::bad_input, fmt::format("{}: dowel '{}' at {} is in the air, {:.3g} m off the nearest block; "
                                             "allowed: a point on a joint",
                                             spec.source.text, spec.name, geometry::place(at), off));
  dowel.drawn_length = kDrawn * geometry::longest_extent(placing.shape_of(nearest).vertices);
  double thinnest = dowel.drawn_length;
  for (int b = 0; b < static_cast<int>(assembly.blocks.size()); ++b) {
    if (distance_from(assembly, assembly.blocks[static_cast<std::size_t>(b)], at) <= placing.allowed_off(b))
      thinnest = std::min(thinnest, geometry::least_extent(placing.shape_of(b)));
  }
  int block[2] = {-1, -1};
  for (const int side : {0, 1}) {
    const Vector beside = at + ((side == 0 ? -1.0 : 1.0) * kBeside * thinnest) * dowel.along;
    block[side] = placing.block_at(beside, &off);
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
  dowel.first = placing.add(block[0], at, true), dowel.second = placing.add(block[1], at);
  return dowel;
}

std::vector<std::string> column_names(const DowelSpec& spec) {
  return {fmt::format("dowel_{}_N", spec.name), fmt::format("dowel_{}_shear_N", spec.name)};
}

// Forces in the frame of the first block, with which the bar turns. The couple of shear and slip is neglected.
void Dowel::pull(std::vector<Node>& nodes, const Surroundings& /*step*/) {
  Node &a = nodes[static_cast<std::size_t>(first)], &b = nodes[static_cast<std::size_t>(second)];
  state.follow(law, along, transposed_times(a.turn, b.x - a.x));
  const Vector force = a.turn * (state.force * along + state.shear);
  a.force += force, b.force -= force;
}

std::vector<Line> Dowel::lines(const std::vector<Node>& nodes) const {
  const Node &a = nodes[static_cast<std::size_t>(first)], &b = nodes[static_cast<std::size_t>(second)];
  const Vector half = (0.5 * drawn_length) * along;
  return {{kDowel, 0, a.x - a.turn * half, b.x + a.turn * half, state.force, state.drawn, 0.0, false}};
}

}  // namespace quoin::members
