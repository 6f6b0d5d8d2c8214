#include "random/design.h"

#include <gmock/gmock.h>

#include <cmath>
#include <set>
#include <vector>

#include "random/counter.h"

namespace quoin::random {
namespace {

TEST(Design, LatinHypercubeHasOneSampleInEveryStratum) {
  const Design design{Method::latin_hypercube, 3, 50, 4};
  for (std::uint64_t d = 0; d < 4; ++d) {
    std::set<int> strata;
    for (std::uint64_t i = 1; i <= 50; ++i) strata.insert(static_cast<int>(design.at(i, d) * 50));
    EXPECT_EQ(strata.size(), 50u);
    EXPECT_GE(*strata.begin(), 0);
    EXPECT_LE(*strata.rbegin(), 49);
  }
  EXPECT_NE(std::floor(50 * design.at(1, 0)), std::floor(50 * design.at(1, 1)));
}

// Ranks of samples are by their random numbers, as they were found one by one in studies that go on.
TEST(Design, RanksOfALatinHypercubeAreTheSameAsOneByOne) {
  constexpr std::uint64_t kSamples = 40;
  const Design design{Method::latin_hypercube, 7, kSamples, 2};
  for (std::uint64_t d = 0; d < 2; ++d) {
    const auto number = [&](std::uint64_t i) { return uniform({7, i, name_of("latin hypercube")}, d); };
    for (std::uint64_t i = 1; i <= kSamples; ++i) {
      int before = 0;
      for (std::uint64_t other = 1; other <= kSamples; ++other) before += number(other) < number(i) ? 1 : 0;
      EXPECT_EQ(static_cast<int>(design.at(i, d) * kSamples), before);
    }
  }
}

// Variance of the mean of a sum over 64 samples: n/12/64 for independent samples, about n/12/64^3 for strata.
TEST(Design, TheirMeansAreAsCloseAsTheirMethod) {
  const auto error = [](Method method) {
    double squares = 0.0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const Design design{method, seed, 64, 3};
      double mean = 0.0;
      for (std::uint64_t i = 1; i <= 64; ++i)
        for (std::uint64_t d = 0; d < 3; ++d) mean += (design.at(i, d) - 0.5) / 64;
      squares += mean * mean / 40;
    }
    return std::sqrt(squares);
  };
  const double independent = std::sqrt(3.0 / 12 / 64);
  EXPECT_NEAR(error(Method::monte_carlo), independent, 0.5 * independent);  // 40 trials: a standard error of 11 %
  EXPECT_NEAR(error(Method::latin_hypercube), independent / 64, 0.5 * independent / 64);
  // A shifted sequence has a random error of half a cell of 1/64 in each dimension; Boost omits the point 0.
  EXPECT_LT(error(Method::sobol), independent / 4);
}

// Of 2^k consecutive points one is in every 2^-k-th of each side, for any shift (modulo 1). All quarters of any two
// sides have equal numbers of points.
TEST(Design, SobolFillsTheCubeEvenly) {
  const Design design{Method::sobol, 5, 0, 6}, still{Method::sobol, 6, 0, 6};
  for (std::uint64_t d = 0; d < 6; ++d) {
    std::set<long> cells;
    for (std::uint64_t i = 1; i <= 64; ++i) {
      double unmoved =
          design.at(i, d) - design.at(1, d);  // distance from the first point, which does not depend on the shift
      if (unmoved < 0.0) unmoved += 1.0;
      cells.insert(std::lround(unmoved * 64) % 64);
    }
    EXPECT_GE(cells.size(), 63u) << d;  // boost begins with the second point of the sequence
  }
  EXPECT_NE(design.at(1, 0), still.at(1, 0));
}

TEST(Design, AnyOrderGivesTheSame) {
  for (const Method method : {Method::monte_carlo, Method::latin_hypercube, Method::sobol}) {
    const Design design{method, 9, 20, 3};
    std::vector<double> forth, back;
    for (std::uint64_t i = 1; i <= 20; ++i) forth.push_back(design.at(i, 2));
    for (std::uint64_t i = 20; i >= 1; --i) back.push_back(design.at(i, 2));
    EXPECT_THAT(std::vector<double>(back.rbegin(), back.rend()), testing::ContainerEq(forth));
    for (const double u : forth) EXPECT_TRUE(u > 0.0 && u < 1.0);
  }
}

}  // namespace
}  // namespace quoin::random
