// The decision for load balancing (step/rank_balance.h). Times in seconds; the estimated cost of each rank is 1.
#include "step/rank_balance.h"

#include <gmock/gmock.h>

#include <vector>

namespace quoin {
namespace {

const std::vector<double> kAlike{1.0, 1.0};

bool look(RankBalance* balance, double one, double other) {
  return balance->is_worth_dividing(std::vector{one, other}, kAlike);
}

TEST(RankBalance, MostOverMeanIsOneWhereAllAreAlike) {
  EXPECT_EQ(most_over_mean(std::vector{2.0, 2.0, 2.0}), 1.0);
  EXPECT_EQ(most_over_mean(std::vector{3.0, 1.0}), 1.5);
  EXPECT_EQ(most_over_mean(std::vector{0.0, 0.0}), 1.0);
}

TEST(RankBalance, OneUnevenWindowIsChance) {
  RankBalance balance;
  EXPECT_FALSE(look(&balance, 3.0, 1.0));
  EXPECT_FALSE(look(&balance, 1.0, 1.0));
  EXPECT_FALSE(look(&balance, 3.0, 1.0));
  EXPECT_TRUE(look(&balance, 3.0, 1.0));
}

TEST(RankBalance, UnevennessBelowTheBoundIsLeftAlone) {
  RankBalance balance;
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(look(&balance, 1.14, 0.86));
}

// With 3 s and 1 s each window loses 1 s, the time of the slowest rank less the mean.
TEST(RankBalance, DividesOnceAsMuchIsLostAsDividingCosts) {
  RankBalance balance;
  balance.costs(3.5);
  for (const bool worth : {false, false, false, true}) EXPECT_EQ(look(&balance, 3.0, 1.0), worth);
}

TEST(RankBalance, ADivisionInVainDoublesWhatTheNextAsksFor) {
  RankBalance balance;
  balance.divided(3.0);
  int windows = 1;
  while (!look(&balance, 3.0, 1.0)) ++windows;
  EXPECT_EQ(windows, 6);
  balance.divided(3.0);
  for (windows = 1; !look(&balance, 3.0, 1.0);) ++windows;
  EXPECT_EQ(windows, 12);
  look(&balance, 1.0, 1.0);  // even times: the last partition was an improvement
  for (windows = 1; !look(&balance, 3.0, 1.0);) ++windows;
  EXPECT_EQ(windows, 3);
}

// Of 8 s the ranks have taken 6 and 2 for equal estimates: 1.5 and 0.5 of the mean.
TEST(RankBalance, MeasuredOverEstimatedIsOfUnevenWindows) {
  RankBalance balance;
  look(&balance, 1.0, 3.0), look(&balance, 1.0, 1.0);
  look(&balance, 3.0, 1.0), look(&balance, 3.0, 1.0);
  EXPECT_THAT(balance.measured_over_estimated(), testing::ElementsAre(1.5, 0.5));
  RankBalance idle;  // a rank without blocks
  idle.is_worth_dividing(std::vector{2.0, 0.0}, std::vector{1.0, 0.0});
  EXPECT_THAT(idle.measured_over_estimated(), testing::ElementsAre(1.0, 1.0));
}

}  // namespace
}  // namespace quoin
