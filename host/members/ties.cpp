// Ties between blocks: their stops, and their forces in a step.
#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "members/tie.h"
#include "scene/generate_blocks.h"

namespace quoin::members {

namespace {

// Points per side of an anchor plate, in the middle of equal parts.
constexpr int kPlatePoints = 6;

TieLaw law_of(const TieSpec& spec, double length) {
  TieLaw law;
  law.stiffness = spec.young_modulus * spec.area / length;
  law.yield = spec.yield_force();
  law.hardening = spec.hardening / (1.0 - spec.hardening) * law.stiffness;
  law.pretension = spec.pretension;
  law.rupture = spec.rupture_strain * length;
  law.slack = spec.slack;
  law.compression = spec.compression;
  return law;
}

// An anchor plate presses evenly on the masonry below it; it has no bending stiffness of its own.
Tie::Stop stop_at(const MemberEnd& end, const Vector& along, const TieSpec& spec, Placing& placing) {
  const Vector at = geometry::vector(end.point);
  const int block = placing.block_of(end);
  if (end.plate[0] == 0.0) return {{placing.add(block, at), 1.0}};
  const Vector up = std::abs(along.y) < 0.9 ? Vector{0, 1, 0} : Vector{1, 0, 0};
  const Vector level = normalized(cross(up, along)), upright = cross(along, level);
  Tie::Stop stop;
  for (int i = 0; i < kPlatePoints; ++i) {
    for (int j = 0; j < kPlatePoints; ++j) {
      const double u = (i + 0.5) / kPlatePoints - 0.5, v = (j + 0.5) / kPlatePoints - 0.5;
      const Vector point = at + (u * end.plate[0]) * level + (v * end.plate[1]) * upright;
      double off = 0.0;
      const int below = placing.block_at(point, &off);
      if (below < 0)
        throw Error(Exit::bad_input,
                    fmt::format("{}: the plate of tie '{}' reaches over the masonry at {}, {:.3g} m off the nearest "
                                "block; allowed: a plate of {:g} x {:g} m wholly on blocks",
                                end.source.text, spec.name, geometry::place(point), off, end.plate[0], end.plate[1]));
      stop.emplace_back(placing.add(below, point), 1.0 / (kPlatePoints * kPlatePoints));
    }
  }
  return stop;
}

Vector mean_of(const std::vector<Node>& nodes, const Tie::Stop& stop, Vector Node::*place) {
  Vector sum;
  for (const auto& [node, share] : stop) sum += share * (nodes[static_cast<std::size_t>(node)].*place);
  return sum;
}

}  // namespace

Vector start_of(const std::vector<Node>& nodes, const Tie::Stop& stop) { return mean_of(nodes, stop, &Node::start); }

Vector place_of(const std::vector<Node>& nodes, const Tie::Stop& stop) { return mean_of(nodes, stop, &Node::x); }

Tie placed(const TieSpec& spec, Placing& placing) {
  std::vector<MemberEnd> ends{spec.from};
  ends.insert(ends.end(), spec.through.begin(), spec.through.end());
  ends.push_back(spec.to);
  Tie tie{spec.name, {}, 0.0, {}, {}};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Vector before = geometry::vector(ends[i > 0 ? i - 1 : 0].point),
                 after = geometry::vector(ends[std::min(i + 1, ends.size() - 1)].point);
    if (i + 1 < ends.size() && !(norm(after - geometry::vector(ends[i].point)) > 0.0))
      throw Error(Exit::bad_input, fmt::format("{}: tie '{}' stays at {}; its length must be more than 0 there",
                                               spec.source.text, spec.name, geometry::place(after)));
    tie.stops.push_back(stop_at(ends[i], normalized(after - before), spec, placing));
  }
  const std::vector<Node>& nodes = placing.nodes;
  const int from = nodes[static_cast<std::size_t>(tie.stops.front().front().first)].block;
  const int to = nodes[static_cast<std::size_t>(tie.stops.back().front().first)].block;
  if (from == to && spec.through.empty())
    throw Error(Exit::bad_input, fmt::format("{}: both ends of tie '{}' are on block {}; give them blocks of their own",
                                             spec.source.text, spec.name, label(placing.assembly, from)));
  for (std::size_t i = 0; i + 1 < tie.stops.size(); ++i)
    tie.length += norm(start_of(nodes, tie.stops[i + 1]) - start_of(nodes, tie.stops[i]));
  tie.law = law_of(spec, tie.length);
  return tie;
}

std::vector<std::string> column_names(const TieSpec& spec) { return {fmt::format("tie_{}_N", spec.name)}; }

// The force is constant along a tie, as it slides through stops without friction.
void Tie::pull(std::vector<Node>& nodes, const Surroundings& step) {
  std::vector<Vector> place;
  for (const Stop& stop : stops) place.push_back(place_of(nodes, stop));
  double now = 0.0;
  for (std::size_t i = 0; i + 1 < place.size(); ++i) now += norm(place[i + 1] - place[i]);
  state.follow(law, now - length, step.jack);
  for (std::size_t i = 0; i + 1 < place.size(); ++i) {
    const Vector span = place[i + 1] - place[i];
    const Vector force = (state.force / norm(span)) * span;
    for (const auto& [node, share] : stops[i]) nodes[static_cast<std::size_t>(node)].force += share * force;
    for (const auto& [node, share] : stops[i + 1]) nodes[static_cast<std::size_t>(node)].force -= share * force;
  }
}

std::vector<Line> Tie::lines(const std::vector<Node>& nodes) const {
  std::vector<Line> lines;
  for (std::size_t k = 0; k + 1 < stops.size(); ++k)
    lines.push_back({kTie, 0, place_of(nodes, stops[k]), place_of(nodes, stops[k + 1]), state.force, state.plastic, 0.0,
                     state.broken != 0});
  return lines;
}

}  // namespace quoin::members
