#include "model/point_order.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "model/lanes.h"

namespace quoin {
namespace {

using Index = std::uint32_t;  // index of a point
constexpr Index kNone = static_cast<Index>(-1);

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
    for (Index i = 0; i < points.size(); ++i) in_row[i] = in_row[i] || next[i] != kNone;
    // Points that extend rows come before points that begin rows on one side only.
    for (const bool only_rows : {true, false}) {
      link(true, false, only_rows);
      link(false, true, only_rows);
    }
  }

  // Continues chains with points whose gridpoint on side a, on side b, or on both is in the next lane.
  void link(bool by_a, bool by_b, bool only_rows = false) {
    using Place = std::tuple<int, int, std::int32_t, std::int32_t>;
    const auto place = [&](Index i) {
      const PointEnds& p = points[i];
      return Place(p.family, p.axis, by_a ? p.a : -1, by_b ? p.b : -1);
    };
    const auto has_place = [&](Index i) { return (by_a && points[i].a >= 0) || (by_b && points[i].b >= 0); };
    const auto count = static_cast<Index>(points.size());
    std::vector<Index> free;
    for (Index i = 0; i < count; ++i) {
      if (!has_previous[i] && has_place(i)) free.push_back(i);
    }
    std::sort(free.begin(), free.end(),
              [&](Index i, Index k) { return std::pair(place(i), i) < std::pair(place(k), k); });
    for (Index i = 0; i < count; ++i) {
      const auto a = next_lane(by_a ? points[i].a : -1), b = next_lane(by_b ? points[i].b : -1);
      if (next[i] != kNone || !has_place(i) || !a || !b) continue;
      const Place wanted(points[i].family, points[i].axis, *a, *b);
      auto found = std::lower_bound(free.begin(), free.end(), wanted,
                                    [&](Index k, const Place& there) { return place(k) < there; });
      while (found != free.end() && place(*found) == wanted && has_previous[*found]) ++found;
      if (found == free.end() || place(*found) != wanted) continue;
      if (only_rows && !in_row[i] && !in_row[*found]) continue;
      next[i] = *found;
      has_previous[*found] = true;
    }
  }

  const std::vector<PointEnds>& points;
  std::vector<Index> next;
  std::vector<bool> has_previous, in_row;  // in_row: whether it has a neighbour on both sides
};

}  // namespace

std::vector<std::uint32_t> point_order(const std::vector<PointEnds>& points) {
  const Chains chains(points);
  struct Chain {
    Index first, length;
  };
  std::vector<Chain> found;
  std::vector<bool> placed(points.size(), false);
  const auto walk = [&](Index first) {
    found.push_back({first, 0});
    for (Index i = first; i != kNone && !placed[i]; i = chains.next[i]) {
      placed[i] = true;
      ++found.back().length;
    }
  };
  const auto count = static_cast<Index>(points.size());
  for (Index i = 0; i < count; ++i) {
    if (!chains.has_previous[i]) walk(i);
  }
  for (Index i = 0; i < count; ++i) {
    if (!placed[i]) walk(i);  // closed chains
  }
  const auto key = [&](const Chain& chain) {
    const PointEnds& first = points[chain.first];
    const std::int32_t leading = first.a >= 0 ? first.a : first.b >= 0 ? first.b : first.joint;
    return std::tuple(first.family, first.axis, chain.length % kLanes != 0, leading, first.joint, chain.first);
  };
  std::sort(found.begin(), found.end(), [&](const Chain& x, const Chain& y) { return key(x) < key(y); });
  std::vector<std::uint32_t> order;
  order.reserve(points.size());
  for (const Chain& chain : found) {
    Index i = chain.first;
    for (Index k = 0; k < chain.length; ++k, i = chains.next[i]) order.push_back(i);
  }
  return order;
}

}  // namespace quoin
