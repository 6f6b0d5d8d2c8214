// Groups of items that are joined in pairs. The first item of a group, that of the lowest number, stands for it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "base/index.h"

namespace quoin {

class JoinedItems {
 public:
  explicit JoinedItems(std::size_t count) : earlier_(count) { std::iota(earlier_.begin(), earlier_.end(), 0); }

  int first_of(int i) {
    while (earlier_[at(i)] != i) i = earlier_[at(i)] = earlier_[at(earlier_[at(i)])];
    return i;
  }
  void join(int a, int b) {
    const int of_a = first_of(a), of_b = first_of(b);
    earlier_[at(std::max(of_a, of_b))] = std::min(of_a, of_b);
  }

 private:
  std::vector<int> earlier_;  // an item of the same group, by item; itself: the first
};

}  // namespace quoin
