#include "model/point_order.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

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
    const auto place = [&](const PointEnds& p) { return Place(p.family, p.axis, by_a ? p.a : -1, by_b ? p.b : -1); };
    const auto has_place = [&](std::size_t i) { return (by_a && points[i].a >= 0) || (by_b && points[i].b >= 0); };
    std::vector<std::pair<Place, std::size_t>> free;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!has_previous[i] && has_place(i)) free.emplace_back(place(points[i]), i);
    }
    std::sort(free.begin(), free.end());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto a = next_lane(by_a ? points[i].a : -1), b = next_lane(by_b ? points[i].b : -1);
      if (next[i] != kNone || !has_place(i) || !a || !b) continue;
      const Place wanted(points[i].family, points[i].axis, *a, *b);
      auto found = std::lower_bound(free.begin(), free.end(), std::pair(wanted, std::size_t{0}));
      while (found != free.end() && found->first == wanted && has_previous[found->second]) ++found;
      if (found == free.end() || found->first != wanted) continue;
      if (only_rows && !in_row[i] && !in_row[found->second]) continue;
      next[i] = found->second;
      has_previous[found->second] = true;
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
