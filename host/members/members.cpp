#include "members/members.h"

#include <algorithm>
#include <numeric>

namespace quoin::members {

Members::Members(const MemberSpecs& specs, const blocks::Assembly& assembly) {
  Placing placing{assembly, nodes_};
  const auto place_all = [&]<class M, class Spec>(const Kind<M, Spec>& kind) {
    for (const Spec& spec : specs.*kind.specs) std::get<std::vector<M>>(lists_).push_back(placed(spec, placing));
  };
  std::apply([&](const auto&... kind) { (place_all(kind), ...); }, kKinds);
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

std::span<const int> Members::nodes_of(int block) const {
  const std::size_t first = block > 0 ? end_of_block_[static_cast<std::size_t>(block) - 1] : 0;
  return std::span(by_block_).subspan(first, end_of_block_[static_cast<std::size_t>(block)] - first);
}

void Members::pull(const Surroundings& step) {
  for (Node& node : nodes_) node.force = {};
  ground_ += step.ground_way;
  Surroundings now = step;
  now.ground = ground_, now.jack = jack_;
  each([&](auto& member) { member.pull(nodes_, now); });
}

double Members::unbalanced() const {
  double largest = 0.0;
  for (const Floor& floor : floors()) largest = std::max(largest, floor.unbalanced());
  for (const Beam& beam : beams()) largest = std::max(largest, beam.unbalanced());
  return largest;
}

double Members::unbalanced_strips() const {
  double largest = 0.0;
  for (const Strip& strip : strips()) largest = std::max(largest, strip.unbalanced());
  return largest;
}

double Members::own_eigenvalue(double mass_scaling) const {
  double largest = 0.0;
  for (const Floor& floor : floors()) largest = std::max(largest, floor.own_eigenvalue(mass_scaling));
  for (const Beam& beam : beams()) largest = std::max(largest, beam.own_eigenvalue(mass_scaling));
  return largest;
}

void Members::set_step(double dt) {
  for (Bed& bed : std::get<std::vector<Bed>>(lists_)) bed.reckoned_step = dt;
}

bool Members::has_dashpots() const { return std::ranges::any_of(beds(), &Bed::has_dashpots); }

Work Members::work() const {
  Work sum;
  each([&](const auto& member) { sum += member.work(); });
  return sum;
}

std::vector<double> Members::columns() const {
  std::vector<double> values;
  each([&](const auto& member) { std::ranges::copy(member.columns(), std::back_inserter(values)); });
  return values;
}

std::vector<Line> Members::lines() const {
  std::vector<Line> all;
  const auto add = [&](const auto& list) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if constexpr (requires { list[i].lines(nodes_); }) {
        for (Line& line : list[i].lines(nodes_)) line.member = static_cast<int>(i), all.push_back(line);
      }
    }
  };
  std::apply([&](const auto&... list) { (add(list), ...); }, lists_);
  return all;
}

std::vector<std::string> column_names(const MemberSpecs& specs) {
  std::vector<std::string> names;
  const auto add = [&](const auto& kind) {
    for (const auto& spec : specs.*kind.specs) std::ranges::copy(column_names(spec), std::back_inserter(names));
  };
  std::apply([&](const auto&... kind) { (add(kind), ...); }, kKinds);
  return names;
}

}  // namespace quoin::members
