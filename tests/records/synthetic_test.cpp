#include "records/synthetic.h"

#include <gtest/gtest.h>

#include <cmath>

#include "records/read_record.h"
#include "records/response_spectrum.h"

namespace quoin {
namespace {

// Values computed by hand from EN 1998-1:2004 (3.2) to (3.5), table 3.2.
TEST(DesignSpectrum, HasTheValuesOfTheCode) {
  const DesignSpectrum b{2.0, 'B', 1, 0.05};
  EXPECT_NEAR(b.acceleration(0.0), 2.4, 1e-12);
  EXPECT_NEAR(b.acceleration(0.075), 2.4 * 1.75, 1e-12);
  EXPECT_NEAR(b.acceleration(0.3), 6.0, 1e-12);
  EXPECT_NEAR(b.acceleration(1.0), 3.0, 1e-12);
  EXPECT_NEAR(b.acceleration(4.0), 6.0 * 0.5 * 2.0 / 16.0, 1e-12);
  EXPECT_NEAR((DesignSpectrum{2.0, 'A', 2, 0.05}.acceleration(0.5)), 2.5, 1e-12);
  EXPECT_NEAR((DesignSpectrum{1.0, 'A', 1, 0.40}.acceleration(0.2)), 2.5 * 0.55, 1e-12);
  EXPECT_ANY_THROW((DesignSpectrum{1.0, 'F'}.acceleration(0.2)));
}

// EN 1998-1:2004, tables 3.2 and 3.3: S, T_B, T_C, T_D of grounds A to E. Damping 2 %: eta = sqrt(10/7).
TEST(DesignSpectrum, GroundsHaveTheirCorners) {
  const double table[2][5][4] = {{{1.0, 0.15, 0.4, 2.0},
                                  {1.2, 0.15, 0.5, 2.0},
                                  {1.15, 0.2, 0.6, 2.0},
                                  {1.35, 0.2, 0.8, 2.0},
                                  {1.4, 0.15, 0.5, 2.0}},
                                 {{1.0, 0.05, 0.25, 1.2},
                                  {1.35, 0.05, 0.25, 1.2},
                                  {1.5, 0.1, 0.25, 1.2},
                                  {1.8, 0.1, 0.3, 1.2},
                                  {1.6, 0.05, 0.25, 1.2}}};
  const double eta = std::sqrt(10.0 / 7.0);
  for (const int type : {1, 2}) {
    for (int i = 0; i < 5; ++i) {
      const DesignSpectrum ground{3.0, static_cast<char>('A' + i), type, 0.02};
      const auto& [soil, b, c, d] = table[type - 1][i];
      const double rigid = 3.0 * soil, plateau = rigid * 2.5 * eta;
      EXPECT_NEAR(ground.acceleration(0.5 * b), 0.5 * (rigid + plateau), 1e-12) << type << ground.ground_type;
      EXPECT_NEAR(ground.acceleration(b), plateau, 1e-12) << type << ground.ground_type;
      EXPECT_NEAR(ground.acceleration(0.999 * c), plateau, 1e-12) << type << ground.ground_type;
      EXPECT_NEAR(ground.acceleration(1.01 * c), plateau / 1.01, 1e-12) << type << ground.ground_type;
      EXPECT_NEAR(ground.acceleration(2.0 * d), plateau * c / d / 4.0, 1e-12) << type << ground.ground_type;
    }
  }
}

// EN 1998-1, 3.2.3.1.2(4): no value below 90 % of the target. Rest at both ends. Computed independently of the
// generator.
TEST(SyntheticRecord, FollowsItsSpectrumAndRestsAtTheEnd) {
  const DesignSpectrum target{2.0, 'B', 1, 0.05};
  const SyntheticRecord made = synthetic_record(target, {});
  const TimeSeries a = acceleration_of(made.record, 0);
  double mean = 0.0;
  const auto periods = default_periods(40);
  int counted = 0;
  for (const SpectralOrdinates& o : response_spectrum(a, 0.05, periods)) {
    if (o.period < 0.06 || o.period > 3.5) continue;
    const double ratio = o.pseudo_acceleration / target.acceleration(o.period);
    EXPECT_GT(ratio, 0.9) << o.period;
    EXPECT_LT(ratio, 1.15) << o.period;
    mean += ratio, ++counted;
  }
  EXPECT_NEAR(mean / counted, 1.0, 0.03);
  EXPECT_NEAR(made.mean_ratio, 1.0, 0.03);
  const RecordMeasures m = measure_record(a);
  EXPECT_NEAR(m.end_velocity, 0.0, 1e-10);
  EXPECT_NEAR(m.end_displacement, 0.0, 1e-9);
  EXPECT_NEAR(made.record.time.back(), 20.0, 1e-9);
}

TEST(SyntheticRecord, SeedAndNumberDecideEveryBit) {
  const DesignSpectrum target{1.0, 'C', 2, 0.05};
  const SyntheticSettings settings{6.0, 0.02, 5, 3};
  SyntheticSettings other = settings;
  other.number = 4;
  const auto first = synthetic_record(target, settings).record.components[0].value;
  EXPECT_EQ(first, synthetic_record(target, settings).record.components[0].value);
  EXPECT_NE(first, synthetic_record(target, other).record.components[0].value);
}

// The shipped record is the first of its suite, with six decimals.
TEST(SyntheticRecord, TheOneThatShipsIsTheFirstOfItsSuite) {
  const GroundRecord shipped = read_record(QUOIN_SCENES "/synthetic_record.csv");
  const GroundRecord made = synthetic_record({2.0, 'B', 1, 0.05}, {}).record;
  ASSERT_EQ(shipped.components[0].value.size(), made.components[0].value.size());
  for (std::size_t i = 0; i < made.time.size(); ++i)
    EXPECT_NEAR(shipped.components[0].value[i], made.components[0].value[i], 6e-7);
}

TEST(SyntheticRecord, RefusesWhatItCannotMake) {
  const DesignSpectrum target{1.0, 'A'};
  EXPECT_ANY_THROW(synthetic_record(target, {1.0, 0.01}));
  EXPECT_ANY_THROW(synthetic_record(target, {20.0, 0.05}));
  EXPECT_ANY_THROW(synthetic_record(target, {20.0, 1e-6}));
}

}  // namespace
}  // namespace quoin
