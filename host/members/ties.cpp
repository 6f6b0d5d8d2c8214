// Ties between blocks: their stops, and their forces in a step.
#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "members/members.h"

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

}  // namespace

// An anchor plate presses evenly on the masonry below it; it has no bending stiffness of its own.
Tie::Stop Members::stop_at(const MemberEnd& end, const Vector& along, const TieSpec& spec,
                           const blocks::Assembly& assembly) {
  const int centre = node_at(end, assembly);
  if (end.plate[0] == 0.0) return {{centre, 1.0}};
  const Vector at = nodes_[static_cast<std::size_t>(centre)].start;
  const Vector up = std::abs(along.y) < 0.9 ? Vector{0, 1, 0} : Vector{1, 0, 0};
  const Vector level = normalized(cross(up, along)), upright = cross(along, level);
  Tie::Stop stop;
  for (int i = 0; i < kPlatePoints; ++i) {
    for (int j = 0; j < kPlatePoints; ++j) {
      const double u = (i + 0.5) / kPlatePoints - 0.5, v = (j + 0.5) / kPlatePoints - 0.5;
      Node node;
      node.start = node.x = at + (u * end.plate[0]) * level + (v * end.plate[1]) * upright;
      double off = 0.0;
      node.block = block_at(node.start, assembly, &off);
      if (node.block < 0)
        throw Error(
            Exit::bad_input,
            fmt::format("{}: the plate of tie '{}' reaches over the masonry at {}, {:.3g} m off the nearest "
                        "block; allowed: a plate of {:g} x {:g} m wholly on blocks",
                        end.source.text, spec.name, geometry::place(node.start), off, end.plate[0], end.plate[1]));
      stop.emplace_back(static_cast<int>(nodes_.size()), 1.0 / (kPlatePoints * kPlatePoints));
      nodes_.push_back(node);
    }
  }
  return stop;
}

Vector Members::start_of(const Tie::Stop& stop) const {
  Vector sum;
  for (const auto& [node, share] : stop) sum += share * nodes_[static_cast<std::size_t>(node)].start;
  return sum;
}

Vector Members::place_of(const Tie::Stop& stop) const {
  Vector sum;
  for (const auto& [node, share] : stop) sum += share * nodes_[static_cast<std::size_t>(node)].x;
  return sum;
}

void Members::add_tie(const TieSpec& spec, const blocks::Assembly& assembly) {
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
    tie.stops.push_back(stop_at(ends[i], normalized(after - before), spec, assembly));
  }
  const int from = nodes_[static_cast<std::size_t>(tie.stops.front().front().first)].block;
  const int to = nodes_[static_cast<std::size_t>(tie.stops.back().front().first)].block;
  if (from == to && spec.through.empty())
    throw Error(Exit::bad_input, fmt::format("{}: both ends of tie '{}' are on block {}; give them blocks of their own",
                                             spec.source.text, spec.name, label(assembly, from)));
  for (std::size_t i = 0; i + 1 < tie.stops.size(); ++i)
    tie.length += norm(start_of(tie.stops[i + 1]) - start_of(tie.stops[i]));
  tie.law = law_of(spec, tie.length);
  ties_.push_back(tie);
}

// The force is constant along a tie, as it slides through stops without friction.
void Members::pull_ties() {
  std::vector<Vector> place;
  for (Tie& tie : ties_) {
    place.clear();
    double length = 0.0;
    for (const Tie::Stop& stop : tie.stops) place.push_back(place_of(stop));
    for (std::size_t i = 0; i + 1 < place.size(); ++i) length += norm(place[i + 1] - place[i]);
    tie.state.follow(tie.law, length - tie.length, jack_);
    for (std::size_t i = 0; i + 1 < place.size(); ++i) {
      const Vector span = place[i + 1] - place[i];
      const Vector force = (tie.state.force / norm(span)) * span;
      for (const auto& [node, share] : tie.stops[i]) nodes_[static_cast<std::size_t>(node)].force += share * force;
      for (const auto& [node, share] : tie.stops[i + 1]) nodes_[static_cast<std::size_t>(node)].force -= share * force;
    }
  }
}

}  // namespace quoin::members
