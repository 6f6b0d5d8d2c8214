// The test rig: a dry wall with a free top rotation rocks at N L/(2 H0), for any height of the force.
#include <gmock/gmock.h>

#include "program.h"
#include "validate/wall_scene.h"
#include "walls.h"

namespace {

using namespace quoin::validate;
using Rig = Cli;

class Rocking : public Cli, public ::testing::WithParamInterface<const char*> {};

// The toe has a width, since blocks and joints deform, so the lever arm is a little shorter than half of the length. A
// force above the equilibrium of the rigid wall is dynamic: tolerance 3 %.
TEST_P(Rocking, ForceFollowsFromTheShearSpan) {
  auto wall = dry_wall();
  wall["shear_span_over_height"] = GetParam();
  write_walls(folder_ / "walls.csv", {wall});
  const WallRow row = read_wall_table((folder_ / "walls.csv").string()).rows.at(0);
  const bool held = std::string(GetParam()) == "0.5";
  // Slow, since a stiff wall vibrates at uplift.
  ASSERT_EQ(quoin({"validate", "--walls", (folder_ / "walls.csv").string(), "--out", out(), "--jobs", "1", "--set",
                   "joints.bed.normal_stiffness=1e11", "--set", "joints.bed.shear_stiffness=4e10", "--set",
                   held ? "stage.shear.velocity=0.002" : "stage.shear.control.2.velocity=[0.004, \"free\", 0]"}),
            0)
      << error_;
  const std::string csv = read_all(folder_ / "out" / "validation.csv");
  const std::string values = csv.substr(csv.find("1,test,dry,") + 11);
  const double peak = std::stod(values), rigid = rocking_force_with_weight(row);
  EXPECT_LT(peak, 1.03 * rigid);
  EXPECT_GT(peak, 0.94 * rigid);
  // Rocking, or a hybrid mode that begins with rocking: dry head joints open where blocks lift off along a stair.
  EXPECT_THAT(csv, ::testing::AnyOf(::testing::HasSubstr(",F,F\n"), ::testing::HasSubstr(",H-FS,F\n")));
}
INSTANTIATE_TEST_SUITE_P(Spans, Rocking, ::testing::Values("0.5", "0.75", "1", "1.5"));

TEST_F(Rig, ALoadHeightIsRefusedWhereItWouldBeLost) {
  EXPECT_EQ(quoin({"check", small_, "--set", "wall.load_height=0.2"}), 3);
  EXPECT_THAT(error_, ::testing::HasSubstr("wall.load_height"));
  EXPECT_THAT(error_, ::testing::HasSubstr("large_motion"));
  EXPECT_EQ(quoin({"check", small_, "--set", "wall.load_height=0.2", "--set", "solver.large_motion=never"}), 0)
      << error_;
}

}  // namespace
