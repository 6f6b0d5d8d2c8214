// `quoin spectrum` through its command line: a PEER file of one component with a spectrum in closed form.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "program.h"

namespace {

using ::testing::HasSubstr;

class Spectrum : public Cli {
 protected:
  // Returns a record with a step of 0.1 g of 10 s.
  std::string step_record() const {
    std::string text =
        "PEER NGA STRONG MOTION DATABASE RECORD\nMade, today, here, 090\nACCELERATION TIME SERIES IN UNITS OF G\n"
        "NPTS=   1001, DT=   .0100 SEC\n";
    for (int i = 0; i < 1001; ++i) text += fmt::format("  .1000000E+00{}", i % 5 == 4 ? "\n" : "");
    const std::string file = (folder_ / "RECORD.AT2").string();
    std::ofstream(file) << text;
    return file;
  }
};

// Damped response to a step: Sd = (a/w^2)(1 + exp(-pi z/sqrt(1 - z^2))) at half a damped period. Tolerance 0.05 %.
TEST_F(Spectrum, OfAStepIsThatOfTheClosedForm) {
  ASSERT_EQ(quoin({"spectrum", step_record(), "--damping", "0.05", "--out", out()}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("1001 samples, 10 s, recorded in g\n"));
  std::istringstream csv(read_all(fs::path(out()) / "spectrum.csv"));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line,
            "component,damping,period_s,displacement_m,velocity_m_s,pseudo_velocity_m_s,pseudo_acceleration_m_s2,"
            "absolute_acceleration_m_s2");
  const double expected = 0.980665 * (1.0 + std::exp(-M_PI * 0.05 / std::sqrt(1.0 - 0.0025)));
  int rows = 0;
  for (; std::getline(csv, line); ++rows) {
    std::istringstream cells(line);
    std::string cell;
    for (int c = 0; c < 7; ++c) std::getline(cells, cell, ',');
    EXPECT_NEAR(std::stod(cell), expected, 1e-3 * expected) << line;
  }
  EXPECT_EQ(rows, 200);
  const auto json = nlohmann::json::parse(read_all(fs::path(out()) / "spectrum.json"));
  EXPECT_NEAR(json["components"][0]["end_velocity_m_s"], 9.80665, 1e-9);
  EXPECT_EQ(json["components"][0]["name"], "090");
  EXPECT_EQ(json["recorded_as"], "g");
}

// Files of one component with one name, as of PEER, have the name of the file in front, or its path.
TEST_F(Spectrum, ComponentsOfFilesWithOneNameHaveThatOfTheirFile) {
  const std::string record = step_record(), other = (folder_ / "EAST.AT2").string(),
                    again = (folder_ / "more/EAST.AT2").string();
  fs::create_directories(folder_ / "more");
  fs::copy_file(record, other), fs::copy_file(record, again);
  const auto names = [&](const std::vector<std::string>& files) {
    std::vector<std::string> words{"spectrum", "--period", "1", "--out", out()};
    words.insert(words.begin() + 1, files.begin(), files.end());
    EXPECT_EQ(quoin(words), 0) << error_;
    std::istringstream csv(read_all(fs::path(out()) / "spectrum.csv"));
    std::vector<std::string> found;
    std::string line;
    for (std::getline(csv, line); std::getline(csv, line);) found.push_back(line.substr(0, line.find(',')));
    return found;
  };
  using testing::ElementsAre;
  EXPECT_THAT(names({record}), ElementsAre("\"090\""));
  EXPECT_THAT(names({record, other}), ElementsAre("\"RECORD 090\"", "\"EAST 090\""));
  EXPECT_THAT(names({record, other, again}),
              ElementsAre("\"RECORD 090\"", "\"" + other + " 090\"", "\"" + again + " 090\""));
}

// A user's own file of the name of a result was replaced without a word. Own results are replaced.
TEST_F(Spectrum, AFileOfTheUserIsKept) {
  const std::vector<std::string> command{"spectrum", step_record(), "--period", "1", "--out", out()};
  fs::create_directories(out());
  std::ofstream(fs::path(out()) / "spectrum.png") << "mine";
  EXPECT_EQ(quoin(command), 3);
  EXPECT_THAT(error_, HasSubstr("has spectrum.png, which would be replaced"));
  EXPECT_EQ(read_all(fs::path(out()) / "spectrum.png"), "mine");
  EXPECT_FALSE(fs::exists(fs::path(out()) / "spectrum.csv"));
  fs::remove(fs::path(out()) / "spectrum.png");
  for (int i = 0; i < 2; ++i) EXPECT_EQ(quoin(command), 0) << error_;
}

TEST_F(Spectrum, BadInputIsNamedAndLeavesNothing) {
  EXPECT_EQ(quoin({"spectrum", (folder_ / "none.at2").string()}), 3);
  EXPECT_THAT(error_, HasSubstr("no such file"));
  EXPECT_EQ(quoin({"spectrum", step_record(), "--damping", "1.5", "--out", out()}), 3);
  EXPECT_THAT(error_, HasSubstr("damping 1.5"));
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_EQ(quoin({"spectrum", step_record(), "--baseline", "high-pass"}), 2);
  EXPECT_THAT(error_, HasSubstr("--corner"));
  EXPECT_EQ(quoin({"spectrum", step_record(), "--scale", "1e308", "--out", out()}), 3);
  EXPECT_THAT(error_, HasSubstr("too large for a spectrum"));
  EXPECT_FALSE(fs::exists(out()));
  EXPECT_EQ(quoin({"spectrum", step_record(), "--period", "1e308"}), 3);  // it did not end
  EXPECT_THAT(error_, HasSubstr("from 1e-06 to 1e+06"));
  for (const std::vector<std::string>& useless :
       {std::vector<std::string>{"--svg"}, {"--order", "2"}, {"--corner", "0.1", "--baseline", "linear"}}) {
    std::vector<std::string> words{"spectrum", step_record()};
    words.insert(words.end(), useless.begin(), useless.end());
    EXPECT_EQ(quoin(words), 2) << useless.front();
    EXPECT_THAT(error_, HasSubstr(useless.front()));
  }
  EXPECT_EQ(quoin({"spectrum", step_record(), "--out", ""}), 2);
  EXPECT_THAT(error_, HasSubstr("--out: an empty name"));
}

}  // namespace
