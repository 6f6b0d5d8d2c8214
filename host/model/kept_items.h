// Arrays of contact points across a contact detection: most items are kept, some are removed, some are new.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace quoin::blocks {

// Consecutive items that are kept: their old and new first index. Lists of them are in ascending order of both.
struct KeptItems {
  uint32_t from, to, count;
};

// Appends kept items to a list; extends its last entry where they follow it.
template <class List>
void keep_on(List& kept, uint32_t from, uint32_t to, uint32_t count) {
  if (count == 0) return;
  if (!kept.empty() && kept.back().from + kept.back().count == from && kept.back().to + kept.back().count == to)
    kept.back().count += count;
  else
    kept.push_back({from, to, count});
}

// Assigns a value to all items that are not kept.
template <class Array>
void fill_others(Array& items, std::span<const KeptItems> kept, const typename Array::value_type& value) {
  uint32_t end = 0;
  for (const KeptItems& k : kept) std::fill(items.begin() + end, items.begin() + k.to, value), end = k.to + k.count;
  std::fill(items.begin() + end, items.end(), value);
}

// Resizes an array to `count` items in place and moves the kept items to their new indices; the others get default
// values. Order is kept. So items that move to lower indices are moved first to last, and the others last to first.
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
