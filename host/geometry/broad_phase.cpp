#include "geometry/broad_phase.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"

namespace quoin::geometry {

namespace {

struct Entry {  // of a box in a cell
  int64_t key;
  int32_t box;
};

// Stable sort by keys in [0, key_count): by counting, unless most keys would have no item.
template <class Item, class Key>
void sort_by_key(std::vector<Item>& items, int64_t key_count, const Key& key) {
  constexpr int64_t kKeysAnItem = 8;
  if (key_count > kKeysAnItem * int64_t(items.size())) {
    std::stable_sort(items.begin(), items.end(), [&](const Item& a, const Item& b) { return key(a) < key(b); });
    return;
  }
  std::vector<uint32_t> next(size_t(key_count) + 1, 0);
  for (const Item& item : items) ++next[size_t(key(item)) + 1];
  for (size_t k = 1; k < next.size(); ++k) next[k] += next[k - 1];
  std::vector<Item> sorted(items.size());
  for (const Item& item : items) sorted[next[size_t(key(item))]++] = item;
  items.swap(sorted);
}

}  // namespace

std::vector<Pair> overlapping_pairs(const std::vector<Box>& boxes) {
  const int n = int(boxes.size());
  std::vector<Pair> pairs;
  if (n < 2) return pairs;
  std::vector<double> extent(boxes.size());
  Box all;
  for (int i = 0; i < n; ++i) {
    const Vector e = boxes[i].upper - boxes[i].lower;
    extent[i] = std::max({e.x, e.y, e.z});
    if (!std::isfinite(extent[i]))
      throw Error(Exit::numerical, fmt::format("block {}: its position is not a number", i));
    all.include(boxes[i].lower), all.include(boxes[i].upper);
  }
  // Cells have the size of a large block, so that a box touches at most 8 cells. The few larger boxes are tested
  // directly.
  std::vector<double> sorted = extent;
  std::nth_element(sorted.begin(), sorted.begin() + n * 9 / 10, sorted.end());
  const double cell = 1.01 * sorted[n * 9 / 10] + 1e-300;
  const Vector span = all.upper - all.lower;
  int64_t count[3];
  // Bounded before conversion to integers: for a block far from all others the number of cells could overflow.
  for (int k = 0; k < 3; ++k) count[k] = int64_t(std::min(span[k] / cell, double((1 << 20) - 1))) + 1;
  auto cell_of = [&](double x, int k) {
    return int64_t(std::clamp((x - all.lower[k]) / cell, 0.0, double(count[k] - 1)));
  };

  std::vector<Entry> entries;
  entries.reserve(size_t(n) * 4);
  std::vector<int32_t> large;
  for (int i = 0; i < n; ++i) {
    int64_t lo[3], hi[3], cells = 1;
    for (int k = 0; k < 3; ++k) {
      lo[k] = cell_of(boxes[i].lower[k], k), hi[k] = cell_of(boxes[i].upper[k], k);
      cells *= hi[k] - lo[k] + 1;
    }
    if (cells > 64) {
      large.push_back(i);
      continue;
    }
    for (int64_t z = lo[2]; z <= hi[2]; ++z) {
      for (int64_t y = lo[1]; y <= hi[1]; ++y) {
        for (int64_t x = lo[0]; x <= hi[0]; ++x) entries.push_back({(z * count[1] + y) * count[0] + x, i});
      }
    }
  }
  sort_by_key(entries, count[0] * count[1] * count[2], [](const Entry& e) { return e.key; });
  for (size_t begin = 0; begin < entries.size();) {
    size_t end = begin;
    while (end < entries.size() && entries[end].key == entries[begin].key) ++end;
    for (size_t i = begin; i < end; ++i) {
      for (size_t j = i + 1; j < end; ++j) {
        const int32_t a = entries[i].box, b = entries[j].box;
        if (!overlap(boxes[a], boxes[b])) continue;
        // The cell with the lower corner of the common box reports a pair that shares several cells.
        const Vector corner = max(boxes[a].lower, boxes[b].lower);
        const int64_t home = (cell_of(corner.z, 2) * count[1] + cell_of(corner.y, 1)) * count[0] + cell_of(corner.x, 0);
        if (home == entries[begin].key) pairs.push_back({a, b});
      }
    }
    begin = end;
  }
  std::vector<bool> is_large(boxes.size(), false);
  for (int32_t l : large) is_large[l] = true;
  for (int32_t l : large) {
    for (int32_t i = 0; i < n; ++i) {
      if (i == l || (is_large[i] && i < l) || !overlap(boxes[i], boxes[l])) continue;
      pairs.push_back({std::min(i, l), std::max(i, l)});
    }
  }
  sort_by_key(pairs, n, [](const Pair& p) { return p.b; });
  sort_by_key(pairs, n, [](const Pair& p) { return p.a; });
  return pairs;
}

}  // namespace quoin::geometry
