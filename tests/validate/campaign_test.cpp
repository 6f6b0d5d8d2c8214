// `quoin validate` through its command line: files, columns, exit codes, reuse of computed samples.
#include "validate/campaign.h"

#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "program.h"
#include "walls.h"

namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class Validate : public Cli {
 protected:
  int validate(const std::vector<std::map<std::string, std::string>>& rows, std::vector<std::string> more = {}) {
    write_walls(folder_ / "walls.csv", rows);
    more.insert(more.begin(), {"validate", "--walls", (folder_ / "walls.csv").string(), "--out", out()});
    return quoin(more);
  }
  std::string csv() const { return read_all(folder_ / "out" / "validation.csv"); }
};

TEST_F(Validate, WritesWhatItPromisesAndComputesNothingTwice) {
  auto first = dry_wall(), second = dry_wall(), bad = dry_wall();
  second["number"] = "2", second["axial_stress_MPa"] = "0.1", second["campaign"] = "a; b";
  bad["number"] = "3", bad["length_m"] = "";
  ASSERT_EQ(validate({first, second, bad}), 0) << error_;
  EXPECT_THAT(error_, HasSubstr("walls.csv:4: length_m"));
  const std::string csv_text = csv();
  EXPECT_THAT(csv_text, StartsWith("number,campaign,specimen,predicted_peak_kN,measured_peak_kN,ratio,predicted_mode,"
                                   "measured_mode\n1,test,dry,"));
  EXPECT_THAT(csv_text, HasSubstr("\n2,a; b,dry,"));
  EXPECT_THAT(csv_text, Not(HasSubstr("\n3,")));
  const std::string page = read_all(folder_ / "out" / "index.html");
  EXPECT_THAT(page, HasSubstr("<svg"));
  EXPECT_THAT(page, HasSubstr("cracks.png"));
  EXPECT_THAT(page, HasSubstr("length_m"));

  ASSERT_EQ(validate({first, second, bad}), 0) << error_;
  EXPECT_THAT(error_, Not(HasSubstr("[1/")));
  EXPECT_EQ(csv(), csv_text);
  // The written scene can be used with `quoin check` and `quoin run`.
  EXPECT_EQ(quoin({"check", (folder_ / "out" / "scenes" / "1_test_dry.toml").string()}), 0) << error_;
}

TEST_F(Validate, NoRowThatRanIsBadInput) {
  auto bad = dry_wall();
  bad["axial_stress_MPa"] = "";
  EXPECT_EQ(validate({bad}), 3);
  EXPECT_THAT(error_, HasSubstr("walls.csv:2: axial_stress_MPa"));
  EXPECT_EQ(quoin({"validate", "--walls", (folder_ / "none.csv").string(), "--out", out()}), 3);
}

TEST_F(Validate, InCyclesBothSidesCount) {
  ASSERT_EQ(validate({dry_wall()}, {"--cyclic"}), 0) << error_;
  EXPECT_THAT(read_all(folder_ / "out" / "scenes" / "1_test_dry_cyclic.toml"), HasSubstr("cyclic_joint"));
  EXPECT_THAT(csv(), HasSubstr("\n1,test,dry,1"));  // 16 kN: 16.0 of the rigid wall, plus the weight
  EXPECT_THAT(read_all(folder_ / "out" / "index.html"), HasSubstr("equivalent damping"));
}

// A dry wall that rocks: its force follows from statics, so the band about the prediction is narrow. Computed samples
// are not computed again.
TEST_F(Validate, BandsHoldThePrediction) {
  ASSERT_EQ(validate({dry_wall()}, {"--bands", "3"}), 0) << error_;
  const std::string bands = read_all(folder_ / "out" / "bands.csv");
  EXPECT_THAT(bands, StartsWith("number,campaign,specimen,samples,peak_p16_kN,peak_median_kN,peak_p84_kN,"
                                "measured_peak_kN\n1,test,dry,3,"));
  std::vector<double> numbers;
  std::stringstream cells(bands.substr(bands.find("dry,3,") + 6));
  for (std::string cell; std::getline(cells, cell, ',');) numbers.push_back(std::stod(cell));
  ASSERT_EQ(numbers.size(), 4u);
  EXPECT_LE(numbers[0], numbers[1]);
  EXPECT_LE(numbers[1], numbers[2]);
  const double predicted = std::stod(csv().substr(csv().find("dry,") + 4));
  EXPECT_NEAR(numbers[1] / predicted, 1.0, 0.1);
  EXPECT_EQ(numbers[3], 16.0);
  ASSERT_EQ(validate({dry_wall()}, {"--bands", "3"}), 0) << error_;
  EXPECT_THAT(error_, Not(HasSubstr("[1/")));
}

// Bounds of the whole campaign, for four walls: mean ratio 1.08 and coefficient of variation 0.15 were measured.
TEST_F(Validate, FourWallsOfTheTable) {
  ASSERT_EQ(quoin({"validate", "--walls", QUOIN_WALLS "/brick_walls.csv", "--short", "--out", out()}), 0) << error_;
  std::stringstream rows(csv());
  std::vector<double> ratios;
  int met = 0;
  std::string line;
  std::getline(rows, line);
  while (std::getline(rows, line)) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    ASSERT_EQ(cells.size(), 8u) << line;
    ratios.push_back(std::stod(cells[5]));
    EXPECT_NEAR(ratios.back(), std::stod(cells[3]) / std::stod(cells[4]), 1e-4) << line;
    met += quoin::validate::leading_mode(cells[6]) == quoin::validate::leading_mode(cells[7]);
  }
  ASSERT_EQ(ratios.size(), 4u);
  const auto s = quoin::validate::statistics_of(ratios);
  EXPECT_GT(s.mean, 0.9);
  EXPECT_LT(s.mean, 1.2);
  EXPECT_LT(s.variation, 0.25);
  EXPECT_GE(met, 3);
}

// Mean 1 and the requested coefficient of variation; 4000 draws have standard errors of 1 and 2 %, tolerance three of
// them.
TEST(Bands, FactorsAreLognormalOfMeanOne) {
  quoin::validate::WallRow row;
  row.number = "7";
  const int draws = 4000;
  double sum = 0.0, squares = 0.0;
  for (int sample = 1; sample <= draws; ++sample) {
    const double factor = quoin::validate::lognormal_factor(row, sample)("bed joint: cohesion", 0.4);
    ASSERT_GT(factor, 0.0);
    sum += factor, squares += factor * factor;
  }
  const double mean = sum / draws;
  EXPECT_NEAR(mean, 1.0, 0.02);
  EXPECT_NEAR(std::sqrt(squares / draws - mean * mean), 0.4, 0.03);
  EXPECT_NE(quoin::validate::lognormal_factor(row, 1)("a", 0.4), quoin::validate::lognormal_factor(row, 1)("b", 0.4));
}

TEST(Bands, QuantilesLieBetweenPeaks) {
  const quoin::validate::Band band{{}, {10.0, 20.0, 40.0}};
  EXPECT_EQ(band.quantile(0.0), 10.0);
  EXPECT_EQ(band.quantile(0.5), 20.0);
  EXPECT_NEAR(band.quantile(0.75), 30.0, 1e-12);
  EXPECT_EQ(band.quantile(1.0), 40.0);
}

TEST(Statistics, AreThoseOfHand) {
  const auto s = quoin::validate::statistics_of({0.8, 1.0, 1.2});
  EXPECT_NEAR(s.mean, 1.0, 1e-12);
  EXPECT_NEAR(s.median, 1.0, 1e-12);
  EXPECT_NEAR(s.variation, 0.2, 1e-12);
  EXPECT_NEAR(quoin::validate::statistics_of({2.0, 0.8, 1.2, 1.0}).median, 1.1, 1e-12);
  EXPECT_EQ(quoin::validate::statistics_of({0.7}).median, 0.7);
  EXPECT_EQ(quoin::validate::statistics_of({0.7}).variation, 0.0);
}

}  // namespace
