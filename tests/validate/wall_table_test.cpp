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
  EXPECT_EQ(mode_of({0.5 * top, 0.0, 0.0, top, 0.95}), "H-FS");  // joints open, but the force does not decrease
  EXPECT_EQ(mode_of({0.0, 0.9 * top, 0.0, top}), "SL");
  EXPECT_EQ(mode_of({0.15 * top, 0.0, 0.0, top}), "H-FS");
  EXPECT_EQ(mode_of({0.0, 0.3 * top, 0.0, top}), "H-FSL");
  // A hybrid mode agrees if its first letter does; sliding is not a diagonal crack.
  EXPECT_EQ(leading_mode("H-FSL"), leading_mode("F"));
  EXPECT_NE(leading_mode("SL"), leading_mode("S"));
}

}  // namespace
