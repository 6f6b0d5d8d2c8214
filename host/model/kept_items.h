// Arrays of contact points, from one contact detection to the next: most items go on, some go, some are new.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace quoin::blocks {

// Items in a row that go on: where they were, and where they are now. Several of them are in the order of both.
struct KeptItems {
  uint32_t from, to, count;
};

// Adds items that go on to a list, to its last ones where they follow these.
template <class List>
void keep_on(List& kept, uint32_t from, uint32_t to, uint32_t count) {
  if (count == 0) return;
  if (!kept.empty() && kept.back().from + kept.back().count == from && kept.back().to + kept.back().count == to)
    kept.back().count += count;
  else
    kept.push_back({from, to, count});
}

// All items that do not go on.
template <class Array>
void fill_others(Array& items, std::span<const KeptItems> kept, const typename Array::value_type& value) {
  uint32_t end = 0;
  for (const KeptItems& k : kept) std::fill(items.begin() + end, items.begin() + k.to, value), end = k.to + k.count;
  std::fill(items.begin() + end, items.end(), value);
}

// An array of `count` items in which these go on, in its place; the others begin by default. Since all keep their
// order, those that move down go first to last, and those that move up last to first.
template <class Array>
void keep_in_place(Array& items, std::span<const KeptItems> kept, std::size_t count) {
  items.resize(std::max(items.size(), count));
  const auto at = items.begin();
  for (const KeptItems& k : kept) {
    if (k.to < k.from) std::copy_n(at + k.from, k.count, at + k.to);
  }
  for (size_t i = kept.size(); i-- > 0;) {
    const KeptItems& k = kept[i];
    if (k.to > k.from) std::copy_backward(at + k.from, at + k.from + k.count, at + k.to + k.count);
  }
  items.resize(count);
  fill_others(items, kept, {});
}

}  // namespace quoin::blocks
