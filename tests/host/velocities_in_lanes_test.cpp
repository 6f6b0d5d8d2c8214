// Steps of large motion change velocities of congruent blocks in lanes (host/model/pieces.h). They copy them to
// Gridpoints only where they measure or check motion. A run with a row each step measures, and so copies, in each step.
// It agrees to the last bit with a run of few rows in whatever stages and users read between steps.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

struct LanesCase {
  const char* name;
  std::string scene, stage;  // its last stage
  std::vector<std::string> overrides;
};

void PrintTo(const LanesCase& of, std::ostream* out) { *out << of.name; }

class VelocitiesInLanes : public ::testing::TestWithParam<LanesCase> {};

TEST_P(VelocitiesInLanes, AreThoseOfARunThatCopiesThemInEachStep) {
  const auto with_rows_each = [](long steps) {
    std::vector<std::string> overrides = GetParam().overrides;
    overrides.push_back("stage." + GetParam().stage + ".record_interval=" + std::to_string(steps));
    overrides.push_back("output.energy=false");  // energies are measured in each step
    return read_scene(GetParam().scene, overrides);
  };
  Simulation each(with_rows_each(1), 2), seldom(with_rows_each(100), 2);
  Observer nobody;
  long without_copy = 0;
  bool goes_on = true;
  for (int part = 0; goes_on && part < 300; ++part) {
    constexpr long kSteps = 7;  // the last of them is seldom that of a row
    goes_on = each.run_stage(nobody, kSteps);
    ASSERT_EQ(seldom.run_stage(nobody, kSteps), goes_on);
    ASSERT_EQ(seldom.step(), each.step()) << "another end of the stage";
    ASSERT_EQ(seldom.hash(), each.hash()) << "step " << each.step();
    without_copy += seldom.large_motion() && !seldom.large_motion()->copies_velocities;
    for (int block = 0; block < seldom.block_count(); ++block) {
      ASSERT_EQ(block_displacement(seldom, block), block_displacement(each, block)) << block;
      ASSERT_EQ(block_velocity(seldom, block), block_velocity(each, block)) << block;
    }
  }
  EXPECT_GT(without_copy, 3) << "parts that end with a step that copied nothing";
}

const std::string kTurnedInLanes = QUOIN_HOST_TESTS "/turned_wall.toml";

INSTANTIATE_TEST_SUITE_P(
    Kinds, VelocitiesInLanes,
    ::testing::Values(
        LanesCase{"Turned", kTurnedInLanes, "pull", {"stage.pull.duration=0.02"}},
        LanesCase{"TurnedWithADeformableMonitor",
                  kTurnedInLanes,
                  "pull",
                  {"stage.pull.monitor=wall/2/0/b", "stage.pull.displacement=2e-5", "stage.pull.duration=1.0"}},
        // Contacts are detected in a step that copies nothing.
        LanesCase{"DetectedWhereARigidBlockDeviates", QUOIN_HOST_TESTS "/thrown_stone.toml", "throw", {}},
        LanesCase{"Promoted",
                  QUOIN_HOST_TESTS "/../cli/small_wall.toml",
                  "shear",
                  {"wall.courses=3", "wall.units_per_course=2", "joints.mortar.tensile_strength=3e4",
                   "joints.mortar.cohesion=5e4", "stage.precompression.duration=0.002", "stage.shear.velocity=0.2",
                   "stage.shear.ramp_time=0.0005", "solver.rotation_bound=1e-5"}}),
    [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace quoin
