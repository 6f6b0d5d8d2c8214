// Tables of walls: blank cells are allowed; messages about faults have line and column.
#include "validate/wall_table.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include "base/error.h"
#include "validate/outcome.h"
#include "walls.h"

namespace {

namespace fs = std::filesystem;
using namespace quoin::validate;
using ::testing::AllOf;
using ::testing::HasSubstr;

class WallTables : public ::testing::Test {
 protected:
  WallTable read(const std::vector<std::map<std::string, std::string>>& rows) {
    write_walls(file_, rows);
    return read_wall_table(file_.string());
  }
  void TearDown() override { fs::remove(file_); }
  const fs::path file_ = fs::temp_directory_path() / ("quoin_walls_" + std::to_string(getpid()) + ".csv");
};

TEST_F(WallTables, TheShippedOneIsRead) {
  const WallTable table = read_wall_table(QUOIN_WALLS "/brick_walls.csv");
  EXPECT_TRUE(table.faults.empty());
  ASSERT_EQ(table.rows.size(), 17u);
  EXPECT_EQ(table.rows[0].specimen, "CS02");
  EXPECT_FALSE(table.rows[0].mortar_modulus);  // blank
  EXPECT_DOUBLE_EQ(table.rows[3].peak(), (269.55 + 259.63) / 2);
  // W1 and W3 occur twice.
  std::vector<std::string> folders;
  for (const WallRow& row : table.rows) folders.push_back(row.folder_name());
  std::sort(folders.begin(), folders.end());
  EXPECT_EQ(std::unique(folders.begin(), folders.end()), folders.end());
}

TEST_F(WallTables, TheShippedOneAgainstRigidEquilibrium) {
  // N L/(2 H0) by hand, kN: 0.4 MPa x 1.5 m x 0.38 m = 228 kN; x 1.5/(2 x 0.5 x 3).
  const WallTable table = read_wall_table(QUOIN_WALLS "/brick_walls.csv");
  const auto wall = [&](const char* number) {
    return *std::find_if(table.rows.begin(), table.rows.end(), [&](const auto& r) { return r.number == number; });
  };
  EXPECT_NEAR(rocking_force(wall("24")), 114.0, 1e-9);
  // MI4, Abrams W3 and CLM05 are above it.
  EXPECT_NEAR(wall("24").peak() / rocking_force(wall("24")), 1.41, 0.01);
  EXPECT_GT(wall("29").peak() / rocking_force_with_weight(wall("29")), 1.3);
  EXPECT_GT(wall("39").peak() / rocking_force_with_weight(wall("39")), 1.15);
  // Weight of MI4: 1800 x 9.81 x 1.5 x 0.38 x 3 = 30.2 kN, times L/(2 H), with rocking about both toes.
  EXPECT_NEAR(rocking_force_with_weight(wall("24")) - rocking_force(wall("24")), 30.2 * 1.5 / 6, 0.01);
}

TEST_F(WallTables, RowsAtFaultAreNamedAndLeftOut) {
  auto good = dry_wall(), no_peak = dry_wall(), letters = dry_wall(), thin = dry_wall(), same = dry_wall();
  no_peak["number"] = "2", no_peak["peak_positive_kN"] = "";
  letters["number"] = "3", letters["height_m"] = "tall";
  thin["number"] = "4", thin["thickness_m"] = "-0.2";
  const WallTable table = read({good, no_peak, letters, thin, same});
  ASSERT_EQ(table.rows.size(), 1u);
  ASSERT_EQ(table.faults.size(), 4u);
  EXPECT_THAT(table.faults[0], AllOf(HasSubstr(":3: peak_positive_kN"), HasSubstr("blank")));
  EXPECT_THAT(table.faults[1], AllOf(HasSubstr(":4: height_m"), HasSubstr("'tall'")));
  EXPECT_THAT(table.faults[2], AllOf(HasSubstr(":5: thickness_m"), HasSubstr("-0.2")));
  EXPECT_THAT(table.faults[3], AllOf(HasSubstr(":6:"), HasSubstr("twice")));
}

// Unknown words were taken for those of other joints and units, and the walls were predicted with their properties.
TEST_F(WallTables, UnknownKindsOfJointsAndUnitsAreNamed) {
  for (const auto& [column, known] :
       std::map<std::string, std::string>{{"bed_joints", "tl"}, {"head_joints", "unfilled"}, {"unit_type", "SB-C"}}) {
    auto good = dry_wall(), wrong = dry_wall();
    good[column] = known;
    wrong["number"] = "2", wrong[column] = "xyzzy";
    const WallTable table = read({good, wrong});
    EXPECT_EQ(table.rows.size(), 1u) << column;
    ASSERT_EQ(table.faults.size(), 1u) << column;
    EXPECT_THAT(table.faults[0], AllOf(HasSubstr(":3: " + column), HasSubstr("'xyzzy'"), HasSubstr("allowed")));
  }
}

// Every number at the end of its range, and beyond it.
TEST_F(WallTables, NumbersHaveTheirRanges) {
  struct Column {
    const char* name;
    double least, most;
    bool positive;
  };
  for (const Column& c : {Column{"courses", 0, 1000, true},
                          Column{"unit_length_mm", 0, 5000, true},
                          Column{"unit_width_mm", 0, 5000, true},
                          Column{"unit_height_mm", 0, 5000, true},
                          Column{"unit_strength_MPa", 0, 500, true},
                          Column{"unit_strength_normalised_MPa", 0, 500, true},
                          Column{"mortar_strength_MPa", 0, 500, true},
                          Column{"masonry_compressive_strength_MPa", 0, 500, true},
                          Column{"masonry_diagonal_tensile_strength_MPa", 0, 50, false},
                          Column{"mortar_modulus_MPa", 0, 1e6, true},
                          Column{"initial_shear_strength_MPa", 0, 20, false},
                          Column{"friction_coefficient", 0, 2, true},
                          Column{"shear_span_over_height", 0.05, 10, false},
                          Column{"peak_positive_kN", -1e5, 1e5, false},
                          Column{"peak_negative_kN", -1e5, 1e5, false},
                          Column{"height_m", 0, 100, true},
                          Column{"length_m", 0, 100, true},
                          Column{"thickness_m", 0, 10, true},
                          Column{"axial_stress_MPa", 0, 100, false},
                          Column{"drift_at_peak_positive_percent", -100, 100, false},
                          Column{"ultimate_drift_negative_percent", -100, 100, false}}) {
    std::vector<std::map<std::string, std::string>> rows;
    for (const double value : {c.most, c.most + 0.01, c.least, c.least - 0.01}) {
      rows.push_back(dry_wall());
      rows.back()["number"] = std::to_string(rows.size());
      rows.back()[c.name] = std::to_string(value);
    }
    const WallTable table = read(rows);
    EXPECT_EQ(table.rows.size(), c.positive ? 1u : 2u) << c.name;
    ASSERT_EQ(table.faults.size(), c.positive ? 3u : 2u) << c.name;
    EXPECT_THAT(table.faults[0], AllOf(HasSubstr(":3: " + std::string(c.name)), HasSubstr("out of range")));
  }
}

TEST_F(WallTables, CellsMayBeQuotedAndDriftsAreMeans) {
  auto wall = dry_wall(), negative = dry_wall();
  wall["campaign"] = "\"a, \"\"b\"\"\"", wall["specimen"] = " W 1/2 ";
  wall["drift_at_peak_positive_percent"] = "0.2", wall["drift_at_peak_negative_percent"] = "-0.4";
  wall["ultimate_drift_positive_percent"] = "0.8";
  negative["number"] = "2", negative["ultimate_drift_negative_percent"] = "-0.9";
  const WallTable table = read({wall, negative});
  ASSERT_EQ(table.rows.size(), 2u) << table.faults.front();
  EXPECT_EQ(table.rows[0].campaign, "a, \"b\"");
  EXPECT_EQ(table.rows[0].folder_name(), "1_a_b__W_1_2");
  EXPECT_EQ(table.rows[0].line, 2);
  EXPECT_NEAR(*table.rows[0].drift_at_peak, 0.3, 1e-12);
  EXPECT_EQ(*table.rows[0].ultimate_drift, 0.8);
  EXPECT_FALSE(table.rows[1].drift_at_peak);
  EXPECT_EQ(*table.rows[1].ultimate_drift, 0.9);
}

TEST_F(WallTables, EnvelopesLieBesideTheTable) {
  const fs::path folder = fs::temp_directory_path() / ("quoin_envelopes_" + std::to_string(getpid()));
  fs::create_directories(folder / "envelopes");
  const auto points = [&](const char* text) {
    std::ofstream(folder / "envelopes" / "dry.csv") << text;
    write_walls(folder / "walls.csv", {dry_wall()});
    return read_wall_table((folder / "walls.csv").string()).rows.at(0).envelope;
  };
  const std::vector<std::array<double, 2>> expected{{-2.0, -15.0}, {0.0, 0.0}, {3.0, 16.0}};
  EXPECT_EQ(points("top_displacement_mm,horizontal_force_kN\n-2,-15\n0,0\n3,16\n"), expected);
  EXPECT_EQ(points("horizontal_force_kN,top_displacement_mm\n-15,-2\n0,0\n16,3\n"), expected);
  EXPECT_THROW(points("x,horizontal_force_kN\n-2,-15\n"), quoin::Error);
  EXPECT_THROW(points("top_displacement_mm,y\n-2,-15\n"), quoin::Error);
  fs::remove_all(folder);
}

TEST_F(WallTables, OneSignIsThePeakAndSignsDoNotMatter) {
  auto one = dry_wall(), both = dry_wall();
  one["peak_positive_kN"] = "", one["peak_negative_kN"] = "-18";
  both["number"] = "2", both["peak_negative_kN"] = "-20";
  const WallTable table = read({one, both});
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_DOUBLE_EQ(table.rows[0].peak(), 18.0);
  EXPECT_DOUBLE_EQ(table.rows[1].peak(), 18.0);
}

TEST_F(WallTables, AHeaderWithoutColumnsIsRefused) {
  std::ofstream(file_) << "number,campaign\n1,a\n";
  try {
    read_wall_table(file_.string());
    FAIL() << "was read";
  } catch (const quoin::Error& error) {
    EXPECT_EQ(error.exit_code, quoin::Exit::bad_input);
    EXPECT_THAT(error.what(), HasSubstr("axial_stress_MPa"));
  }
}

TEST(Modes, AreToldFromWhatMoves) {
  const double top = 0.01;
  EXPECT_EQ(mode_of({0.0, 0.0, 0.0, top}), "F");
  EXPECT_EQ(mode_of({0.5 * top, 0.0, 0.0, top, 0.5}), "S");
  // Just above and below each bound of the table in host/validate/README.md.
  EXPECT_EQ(mode_of({0.251 * top, 0.0, 0.0, top, 0.79}), "S");
  EXPECT_EQ(mode_of({0.249 * top, 0.0, 0.0, top, 0.79}), "H-FS");
  EXPECT_EQ(mode_of({0.251 * top, 0.0, 0.0, top, 0.81}), "H-FS");
  EXPECT_EQ(mode_of({0.251 * top, 0.21 * top, 0.0, top, 0.79}), "H-SSL");
  EXPECT_EQ(mode_of({0.081 * top, 0.21 * top, 0.0, top}), "H-FSSL");
  EXPECT_EQ(mode_of({0.081 * top, 0.19 * top, 0.0, top}), "H-FS");
  EXPECT_EQ(mode_of({0.079 * top, 0.19 * top, 0.0, top}), "F");
  EXPECT_EQ(mode_of({0.079 * top, 0.49 * top, 0.0, top}), "H-FSL");
  EXPECT_EQ(mode_of({0.251 * top, 0.51 * top, 0.0, top}), "H-SLS");
  EXPECT_EQ(mode_of({0.249 * top, 0.51 * top, 0.0, top}), "SL");
  EXPECT_EQ(mode_of({1.0, 1.0, 0.0, 0.0}), "F");
  EXPECT_EQ(mode_of({0.5 * top, 0.0, 0.0, top, 0.95}), "H-FS");  // joints open, but the force does not decrease
  EXPECT_EQ(mode_of({0.0, 0.9 * top, 0.0, top}), "SL");
  EXPECT_EQ(mode_of({0.15 * top, 0.0, 0.0, top}), "H-FS");
  EXPECT_EQ(mode_of({0.0, 0.3 * top, 0.0, top}), "H-FSL");
  // A hybrid mode agrees if its first letter does; sliding is not a diagonal crack.
  EXPECT_EQ(leading_mode("H-FSL"), leading_mode("F"));
  EXPECT_NE(leading_mode("SL"), leading_mode("S"));
}

}  // namespace
