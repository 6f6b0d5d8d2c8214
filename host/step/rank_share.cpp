#include "step/rank_share.h"

#include <algorithm>
#include <numeric>

namespace quoin {

RankShare whole_share(int chunks, int items) {
  RankShare share;
  share.chunks.resize(static_cast<std::size_t>(chunks));
  share.items.resize(static_cast<std::size_t>(items));
  std::iota(share.chunks.begin(), share.chunks.end(), 0);
  std::iota(share.items.begin(), share.items.end(), 0);
  return share;
}

namespace {

struct Bisection {
  const std::vector<Vec3>& place;
  const std::vector<double>& cost;
  std::vector<int> rank;

  void divide(std::span<int> items, int first_rank, int ranks) {
    if (ranks == 1 || items.empty()) {
      for (const int i : items) rank[static_cast<std::size_t>(i)] = first_rank;
      return;
    }
    Vec3 low = place[static_cast<std::size_t>(items[0])], high = low;
    for (const int i : items) {
      for (std::size_t c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], place[static_cast<std::size_t>(i)][c]);
        high[c] = std::max(high[c], place[static_cast<std::size_t>(i)][c]);
      }
    }
    std::size_t axis = 0;
    for (std::size_t c = 1; c < 3; ++c) {
      if (high[c] - low[c] > high[axis] - low[axis]) axis = c;
    }
    std::sort(items.begin(), items.end(), [&](int i, int k) {
      const double x = place[static_cast<std::size_t>(i)][axis], y = place[static_cast<std::size_t>(k)][axis];
      return x != y ? x < y : i < k;
    });
    double whole = 0.0, below = 0.0;
    for (const int i : items) whole += cost[static_cast<std::size_t>(i)];
    const int lower_ranks = ranks / 2;
    const double wanted = whole * lower_ranks / ranks;
    std::size_t cut = 0;
    while (cut < items.size() && below + 0.5 * cost[static_cast<std::size_t>(items[cut])] <= wanted)
      below += cost[static_cast<std::size_t>(items[cut++])];
    divide(items.first(cut), first_rank, lower_ranks);
    divide(items.subspan(cut), first_rank + lower_ranks, ranks - lower_ranks);
  }
};

}  // namespace

std::vector<int> bisect(const std::vector<Vec3>& place, const std::vector<double>& cost, int ranks) {
  std::vector<int> items(place.size());
  std::iota(items.begin(), items.end(), 0);
  Bisection bisection{place, cost, std::vector<int>(place.size(), 0)};
  bisection.divide(items, 0, ranks);
  return bisection.rank;
}

}  // namespace quoin
