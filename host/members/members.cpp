#include "members/members.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "scene/generate_blocks.h"
#include "scene/load_place.h"

namespace quoin::members {

namespace {

// Tolerance of an end's distance from a block, over the block's largest extent: scenes have rounded coordinates.
constexpr double kOffBlock = 1e-3;

std::string column_of_tie(const std::string& name) { return "tie_" + name + "_N"; }

}  // namespace

double allowed_off(const blocks::Assembly& assembly, int block) {
  const int shape = assembly.blocks[static_cast<std::size_t>(block)].shape;
  return kOffBlock * geometry::longest_extent(assembly.shapes[static_cast<std::size_t>(shape)].vertices);
}

Members::Members(const MemberSpecs& specs, const blocks::Assembly& assembly) {
  for (const TieSpec& spec : specs.ties) add_tie(spec, assembly);
  for (const SpringSpec& spec : specs.springs) add_bed(spec, assembly);
  for (const StripSpec& spec : specs.strips) add_strip(spec, assembly);
  for (const FloorSpec& spec : specs.floors) add_floor(spec, assembly);
  for (const BeamSpec& spec : specs.beams) add_beam(spec, assembly);
  for (const DowelSpec& spec : specs.dowels) add_dowel(spec, assembly);
  for (const FillSpec& spec : specs.fills) add_fill(spec, assembly);
  sort_nodes(assembly.blocks.size());
}

void Members::sort_nodes(std::size_t blocks) {
  const auto block_of = [&](int node) { return nodes_[static_cast<std::size_t>(node)].block; };
  by_block_.resize(nodes_.size());
  std::iota(by_block_.begin(), by_block_.end(), 0);
  std::stable_sort(by_block_.begin(), by_block_.end(), [&](int a, int b) { return block_of(a) < block_of(b); });
  end_of_block_.assign(blocks, 0);
  std::size_t n = 0;
  for (std::size_t b = 0; b < blocks; ++b) {
    while (n < by_block_.size() && block_of(by_block_[n]) == static_cast<int>(b)) ++n;
    end_of_block_[b] = n;
  }
}

int Members::node_at(const MemberEnd& end, const blocks::Assembly& assembly) {
  Node node;
  node.start = node.x = geometry::vector(end.point);
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
    const double outside = distance_from(assembly, assembly.blocks[static_cast<std::size_t>(block)], node.start);
    if (outside < least) least = outside, nearest = block;
    if (outside <= allowed_off(assembly, block)) has.push_back(block);
  }
  if (has.empty())
    throw Error(Exit::bad_input,
                fmt::format("{}: the end at {} is in the air: {} {} is {:.3g} m away at least; allowed: a point in a "
                            "block or on its face",
                            end.source.text, geometry::place(node.start),
                            end.block.empty() ? "the nearest block," : "block", label(assembly, nearest), least));
  node.block = nearest;
  // A point on a common face belongs to both blocks, so neither can be chosen.
  for (const int block : has) {
    if (block == nearest ||
        distance_from(assembly, assembly.blocks[static_cast<std::size_t>(block)], node.start) > least + 1e-9)
      continue;
    throw Error(Exit::bad_input,
                fmt::format("{}: the end at {} is where blocks {} and {} meet; {}", end.source.text,
                            geometry::place(node.start), label(assembly, nearest), label(assembly, block),
                            end.block.empty() ? "move it into one of them, or name that as block"
                                              : "move it into one of them"));
  }
  nodes_.push_back(node);
  return static_cast<int>(nodes_.size()) - 1;
}

std::span<const int> Members::nodes_of(int block) const {
  const std::size_t first = block > 0 ? end_of_block_[static_cast<std::size_t>(block) - 1] : 0;
  return std::span(by_block_).subspan(first, end_of_block_[static_cast<std::size_t>(block)] - first);
}

void Members::pull(const Surroundings& step) {
  for (Node& node : nodes_) node.force = {};
  pull_beds(step.ground_way, step.dt);
  for (Strip& strip : strips_) strip.pull(nodes_, step.dt);
  for (Floor& floor : floors_) floor.pull(nodes_, step);
  for (Beam& beam : beams_) beam.pull(nodes_, step);
  pull_ties();
  pull_dowels();
  pull_fills();
}

double Members::unbalanced() const {
  double largest = 0.0;
  for (const Floor& floor : floors_) largest = std::max(largest, floor.unbalanced());
  for (const Beam& beam : beams_) largest = std::max(largest, beam.unbalanced());
  return largest;
}

Work Members::work() const {
  Work sum;
  for (const Tie& tie : ties_) {
    sum.stored += tie.state.stored, sum.dissipated += tie.state.dissipated;
    sum.outside += tie.state.jack_work;
  }
  for (const SpringPoint& p : points_) sum.stored += p.state.stored, sum.dissipated += p.state.dissipated;
  for (const Dowel& d : dowels_) sum.stored += d.state.stored, sum.dissipated += d.state.dissipated;
  for (const FillPoint& p : fill_points_) {
    sum.stored += p.state.stored, sum.dissipated += p.state.dissipated;
    sum.outside += p.state.outside;
  }
  for (const Strip& strip : strips_) sum.stored += strip.stored(), sum.dissipated += strip.dissipated();
  for (const Floor& floor : floors_)
    sum.stored += floor.stored(), sum.dissipated += floor.dissipated(), sum.outside += floor.outside();
  for (const Beam& beam : beams_)
    sum.stored += beam.stored(), sum.dissipated += beam.dissipated(), sum.outside += beam.outside();
  sum.outside += ground_work_;
  return sum;
}

double Members::unbalanced_strips() const {
  double largest = 0.0;
  for (const Strip& strip : strips_) largest = std::max(largest, strip.unbalanced());
  return largest;
}

std::vector<double> Members::columns() const {
  std::vector<double> values;
  for (const Tie& tie : ties_) values.push_back(tie.state.force);
  for (const Bed& bed : beds_) {
    const Vector force = force_of(bed);
    values.insert(values.end(), {force.x, force.y, force.z});
  }
  for (const Strip& strip : strips_) values.insert(values.end(), {strip.largest_force(), strip.debonded_length()});
  for (const Floor& floor : floors_)
    values.insert(values.end(), {floor.largest_shear(), floor.largest_anchor(), floor.pulled_out_length()});
  for (const Beam& beam : beams_)
    values.insert(values.end(), {beam.largest_force(), beam.largest_moment(), beam.largest_hinge()});
  for (const Dowel& dowel : dowels_) values.insert(values.end(), {dowel.state.force, norm(dowel.state.shear)});
  for (const Fill& fill : fills_) {
    const Vector force = force_of(fill);
    values.insert(values.end(), {force.x, force.y, force.z});
  }
  return values;
}

double Members::own_eigenvalue(double mass_scaling) const {
  double largest = 0.0;
  for (const Floor& floor : floors_) largest = std::max(largest, floor.own_eigenvalue(mass_scaling));
  for (const Beam& beam : beams_) largest = std::max(largest, beam.own_eigenvalue(mass_scaling));
  return largest;
}

std::vector<Line> Members::lines() const {
  std::vector<Line> lines;
  for (std::size_t i = 0; i < ties_.size(); ++i) {
    const Tie& tie = ties_[i];
    for (std::size_t k = 0; k + 1 < tie.stops.size(); ++k)
      lines.push_back({kTie, static_cast<int>(i), place_of(tie.stops[k]), place_of(tie.stops[k + 1]), tie.state.force,
                       tie.state.plastic, 0.0, tie.state.broken != 0});
  }
  for (std::size_t i = 0; i < dowels_.size(); ++i) {
    const Dowel& dowel = dowels_[i];
    const Node &first = nodes_[static_cast<std::size_t>(dowel.first)],
               &second = nodes_[static_cast<std::size_t>(dowel.second)];
    const Vector half = (0.5 * dowel.drawn_length) * dowel.along;
    lines.push_back({kDowel, static_cast<int>(i), first.x - first.turn * half, second.x + first.turn * half,
                     dowel.state.force, dowel.state.drawn, 0.0, false});
  }
  for (std::size_t i = 0; i < strips_.size(); ++i) {
    const Strip& strip = strips_[i];
    for (std::size_t k = 0; k < strip.forces().size(); ++k)
      lines.push_back({kStrip, static_cast<int>(i), strip.nodes()[k], strip.nodes()[k + 1], strip.forces()[k], 0.0, 0.0,
                       strip.is_broken(k)});
  }
  for (std::size_t i = 0; i < beams_.size(); ++i) {
    const Beam& beam = beams_[i];
    for (std::size_t k = 0; k < beam.pieces().size(); ++k) {
      const Beam::Piece& p = beam.pieces()[k];
      const double up = std::max(std::abs(p.moment[0][0]), std::abs(p.moment[0][1])),
                   side = std::max(std::abs(p.moment[1][0]), std::abs(p.moment[1][1]));
      lines.push_back({kBeam, static_cast<int>(i), beam.nodes()[k], beam.nodes()[k + 1], p.force, p.plastic,
                       std::max(up, side), false});
    }
  }
  return lines;
}

std::vector<std::string> column_names(const MemberSpecs& specs) {
  std::vector<std::string> names;
  for (const TieSpec& tie : specs.ties) names.push_back(column_of_tie(tie.name));
  for (const SpringSpec& spring : specs.springs) {
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("spring_{}_{}_N", spring.name, axis));
  }
  for (const StripSpec& strip : specs.strips)
    names.insert(names.end(), {fmt::format("strip_{}_N", strip.name), fmt::format("strip_{}_debonded_m", strip.name)});
  for (const FloorSpec& floor : specs.floors)
    names.insert(names.end(),
                 {fmt::format("floor_{}_shear_N_per_m", floor.name), fmt::format("floor_{}_anchor_N_per_m", floor.name),
                  fmt::format("floor_{}_pulled_out_m", floor.name)});
  for (const BeamSpec& beam : specs.beams)
    names.insert(names.end(), {fmt::format("beam_{}_N", beam.name), fmt::format("beam_{}_Nm", beam.name),
                               fmt::format("beam_{}_hinge_rad", beam.name)});
  for (const DowelSpec& dowel : specs.dowels)
    names.insert(names.end(), {fmt::format("dowel_{}_N", dowel.name), fmt::format("dowel_{}_shear_N", dowel.name)});
  for (const FillSpec& fill : specs.fills) {
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("fill_{}_{}_N", fill.name, axis));
  }
  return names;
}

}  // namespace quoin::members
