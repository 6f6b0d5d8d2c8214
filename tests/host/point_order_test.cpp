// The order of contact points in memory: points of neighbouring lanes are stored next to each other.
#include "model/point_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "model/lanes.h"

namespace quoin {
namespace {

using Ends = std::vector<PointEnds>;

// Returns the points in the order of storage, from a random order.
Ends ordered(Ends points) {
  std::shuffle(points.begin(), points.end(), std::mt19937_64(7));
  const std::vector<std::uint32_t> order = point_order(points);
  std::vector<std::uint32_t> sorted = order;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) EXPECT_EQ(sorted[i], i);
  Ends result;
  for (const std::size_t i : order) result.push_back(points[i]);
  return result;
}

std::int32_t gridpoint(int line, int lane) { return line * kLine + lane; }

TEST(PointOrder, RowsOfLanesStandTogetherAndFullOnesFirst) {
  Ends points;
  for (int lane = 0; lane < 5; ++lane) points.push_back({0, 1, lane, gridpoint(0, lane), gridpoint(9, lane)});
  for (int lane = 0; lane < kLanes; ++lane) points.push_back({0, 1, lane, gridpoint(4, lane), gridpoint(2, lane)});
  const Ends found = ordered(points);
  for (int i = 0; i < kLanes; ++i) EXPECT_EQ(found[static_cast<std::size_t>(i)].a, gridpoint(4, i));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(found[static_cast<std::size_t>(kLanes + i)].a, gridpoint(0, i));
}

// A column of blocks on each other in the lanes of one group, between two other blocks. Its nine points are contiguous,
// so that both faces of the group read them without gathers.
TEST(PointOrder, AShiftedRowHoldsWhatJoinsItToOthers) {
  constexpr int kTop = 3, kBottom = 5, kBelow = 30, kAbove = 40;
  Ends points;
  for (const int column : {0, 1}) {  // neighbours below and above are in one row of lanes, which must not be preferred
    points.push_back({0, 1, 0, gridpoint(kBelow, column), gridpoint(kBottom + 10 * column, 0)});
    for (int lane = 0; lane + 1 < kLanes; ++lane)
      points.push_back({0, 1, 1, gridpoint(kTop + 10 * column, lane), gridpoint(kBottom + 10 * column, lane + 1)});
    points.push_back({0, 1, 2, gridpoint(kTop + 10 * column, kLanes - 1), gridpoint(kAbove, column)});
  }
  const Ends found = ordered(points);
  for (std::size_t first : {0u, 9u}) {
    EXPECT_GE(found[first].a, gridpoint(kBelow, 0));
    EXPECT_GE(found[first + 8].b, gridpoint(kAbove, 0));
    for (std::size_t i = first; i < first + 7; ++i) EXPECT_EQ(found[i + 1].b, found[i].b + 1);
    for (std::size_t i = first + 1; i < first + 8; ++i) EXPECT_EQ(found[i + 1].a, found[i].a + 1);
  }
}

TEST(PointOrder, FamiliesThenAxesAndLoneBodiesKeepTheOrderOfTheirJoints) {
  Ends points;
  for (int i = 0; i < 6; ++i) points.push_back({1 - i % 2, i % 3, i, -1, -1});
  const Ends found = ordered(points);
  for (std::size_t i = 0; i + 1 < found.size(); ++i)
    EXPECT_LT(std::tuple(found[i].family, found[i].axis, found[i].joint),
              std::tuple(found[i + 1].family, found[i + 1].axis, found[i + 1].joint));
}

// Cycles in the order of points must not cause an endless loop or lose points.
TEST(PointOrder, AnyPointsComeBack) {
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> offset(-1, 15);
  for (int n = 0; n < 200; ++n) {
    Ends points;
    for (int i = 0; i < 40; ++i) points.push_back({0, 0, i, offset(random), offset(random)});
    ordered(points);
  }
}

}  // namespace
}  // namespace quoin
