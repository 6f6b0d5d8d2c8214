#include "model/point_order.h"

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

#include "model/lanes.h"

namespace quoin {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// The gridpoint of the next lane of the same line.
std::optional<std::int32_t> next_lane(std::int32_t offset) {
  if (offset < 0) return offset;
  if (offset % kLanes == kLanes - 1) return {};
  return offset + 1;
}

struct Chains {
  explicit Chains(const std::vector<PointEnds>& points_in)
      : points(points_in), next(points.size(), kNone), has_previous(points.size(), false) {
    link(true, true);
    in_row = has_previous;
    for (std::size_t i = 0; i < points.size(); ++i) in_row[i] = in_row[i] || next[i] != kNone;
    // What makes rows longer comes before new ones of one side only.
    for (const bool only_rows : {true, false}) {
      link(true, false, only_rows);
      link(false, true, only_rows);
    }
  }

  // Continues chains with points whose gridpoint on side a, on side b, or on both is in the next lane.
  void link(bool by_a, bool by_b, bool only_rows = false) {
    using Place = std::tuple<int, int, std::int32_t, std::int32_t>;
    std::map<Place, std::vector<std::size_t>> at;
    const auto has_place = [&](const PointEnds& p) { return (by_a && p.a >= 0) || (by_b && p.b >= 0); };
    for (std::size_t i = points.size(); i-- > 0;) {
      const PointEnds& p = points[i];
      if (!has_previous[i] && has_place(p)) at[{p.family, p.axis, by_a ? p.a : -1, by_b ? p.b : -1}].push_back(i);
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const PointEnds& p = points[i];
      const auto a = next_lane(by_a ? p.a : -1), b = next_lane(by_b ? p.b : -1);
      if (next[i] != kNone || !has_place(p) || !a || !b) continue;
      const auto found = at.find({p.family, p.axis, *a, *b});
      if (found == at.end() || found->second.empty()) continue;
      if (only_rows && !in_row[i] && !in_row[found->second.back()]) continue;
      next[i] = found->second.back();
      has_previous[next[i]] = true;
      found->second.pop_back();
    }
  }

  const std::vector<PointEnds>& points;
  std::vector<std::size_t> next;
  std::vector<bool> has_previous, in_row;  // in_row: has a neighbour on both sides
};

}  // namespace

std::vector<std::size_t> point_order(const std::vector<PointEnds>& points) {
  const Chains chains(points);
  std::vector<std::vector<std::size_t>> found;
  std::vector<bool> placed(points.size(), false);
  const auto walk = [&](std::size_t first) {
    found.emplace_back();
    for (std::size_t i = first; i != kNone && !placed[i]; i = chains.next[i]) {
      placed[i] = true;
      found.back().push_back(i);
    }
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!chains.has_previous[i]) walk(i);
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!placed[i]) walk(i);  // rings
  }
  const auto key = [&](const std::vector<std::size_t>& chain) {
    const PointEnds& first = points[chain.front()];
    const std::int32_t leading = first.a >= 0 ? first.a : first.b >= 0 ? first.b : first.joint;
    return std::tuple(first.family, first.axis, chain.size() % kLanes != 0, leading, first.joint, chain.front());
  };
  std::sort(found.begin(), found.end(), [&](const auto& x, const auto& y) { return key(x) < key(y); });
  std::vector<std::size_t> order;
  for (const auto& chain : found) order.insert(order.end(), chain.begin(), chain.end());
  return order;
}

}  // namespace quoin
