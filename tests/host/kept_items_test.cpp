// Arrays that keep most of their items in place, against an equal array that is built from scratch
// (model/kept_items.h).
#include "model/kept_items.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace quoin::blocks {
namespace {

// At random, rows of items are kept, emptied, or replaced by another number of new items.
TEST(KeptItems, AreThoseOfAnArrayBuiltAnew) {
  std::mt19937 random(7);  // any seed: every outcome is checked
  const auto number = [&](int most) { return static_cast<uint32_t>(random() % static_cast<unsigned>(most + 1)); };
  int moved_up = 0, moved_down = 0;
  for (int round = 0; round < 500; ++round) {
    std::vector<int> items, wanted;
    std::vector<KeptItems> kept;
    for (int row = 0; row < 12; ++row) {
      const uint32_t count = number(5), from = static_cast<uint32_t>(items.size()),
                     to = static_cast<uint32_t>(wanted.size());
      for (uint32_t i = 0; i < count; ++i) items.push_back(1 + static_cast<int>(items.size()));
      if (number(2) > 0) {
        wanted.insert(wanted.end(), items.begin() + from, items.end());
        keep_on(kept, from, to, count);
        moved_up += count > 0 && to > from, moved_down += count > 0 && to < from;
      } else {
        wanted.resize(wanted.size() + number(5), 0);
      }
    }
    keep_in_place(items, std::span<const KeptItems>(kept), wanted.size());
    ASSERT_EQ(items, wanted) << "round " << round;
    for (std::size_t i = 1; i < kept.size(); ++i)
      ASSERT_TRUE(kept[i - 1].from + kept[i - 1].count < kept[i].from ||
                  kept[i - 1].to + kept[i - 1].count < kept[i].to)
          << "neighbours that could be one row";
  }
  EXPECT_GT(moved_up, 100);
  EXPECT_GT(moved_down, 100);
}

TEST(KeptItems, OthersHaveTheValueAskedFor) {
  std::vector<double> values{1, 2, 3, 4, 5};
  const std::vector<KeptItems> kept{{0, 1, 2}, {4, 5, 1}};
  keep_in_place(values, std::span<const KeptItems>(kept), 7);
  fill_others(values, std::span<const KeptItems>(kept), 9.0);
  EXPECT_EQ(values, (std::vector<double>{9, 1, 2, 9, 9, 5, 9}));
}

}  // namespace
}  // namespace quoin::blocks
