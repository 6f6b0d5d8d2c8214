#include "random/counter.h"

#include <gmock/gmock.h>

#include <cmath>
#include <set>

namespace quoin::random {
namespace {

using Words = std::array<std::uint64_t, 4>;

// Reference values of Philox 4x64-10: kat_vectors of Random123 1.14.
TEST(Counter, PhiloxGivesTheKnownAnswers) {
  constexpr std::uint64_t kOnes = ~std::uint64_t{0};
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}),
            (Words{0x16554d9eca36314c, 0xdb20fe9d672d0fdc, 0xd7e772cee186176b, 0x7e68b68aec7ba23b}));
  EXPECT_EQ(philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}),
            (Words{0x87b092c3013fe90b, 0x438c3c67be8d0224, 0x9cc7d7c69cd777b6, 0xa09caebf594f0ba0}));
  EXPECT_EQ(philox({0x243f6a8885a308d3, 0x13198a2e03707344, 0xa4093822299f31d0, 0x082efa98ec4e6c89},
                   {0x452821e638d01377, 0xbe5466cf34e90c6c}),
            (Words{0xa528f45403e61d95, 0x38c72dbd566e9788, 0xa5a1610e72fd18b5, 0x57bd43b5e52b7fe6}));
}

// Reference values of FNV-1a, 64 bits.
TEST(Counter, NamesAreFnv1a) {
  EXPECT_EQ(name_of(""), 0xcbf29ce484222325u);
  EXPECT_EQ(name_of("foobar"), 0x85944171f73967e8u);
}

TEST(Counter, EveryPartOfTheKeyCounts) {
  std::set<double> drawn;
  const Quantity q{7, 3, name_of("cohesion")};
  for (const Quantity& other :
       {q, Quantity{8, 3, q.name}, Quantity{7, 4, q.name}, Quantity{7, 3, name_of("tensile_strength")}})
    for (std::uint64_t element : {0u, 1u}) drawn.insert(uniform(other, element));
  EXPECT_EQ(drawn.size(), 8u);
}

// Tolerances: 5 standard errors of the estimates from 1e6 draws. A random failure has a probability of one in 2
// million, and the draws are equal in every run.
TEST(Counter, NormalNumbersHaveTheMomentsOfTheNormalDistribution) {
  constexpr int kDraws = 1000000;
  double moment[4] = {}, lag = 0.0, before = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double z = normal({1, 1, 1}, static_cast<std::uint64_t>(i));
    double power = 1.0;
    for (double& m : moment) m += (power *= z) / kDraws;
    lag += z * before / kDraws;
    before = z;
  }
  EXPECT_NEAR(moment[0], 0.0, 5.0 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(moment[1], 1.0, 5.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(moment[2], 0.0, 5.0 * std::sqrt(15.0 / kDraws));
  EXPECT_NEAR(moment[3], 3.0, 5.0 * std::sqrt(96.0 / kDraws));
  EXPECT_NEAR(lag, 0.0, 5.0 * std::sqrt(1.0 / kDraws));  // neighbours are uncorrelated
}

}  // namespace
}  // namespace quoin::random
