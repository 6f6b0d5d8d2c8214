// Steps of large motion change velocities of congruent blocks in lanes, and copy them to Gridpoints only where they
// measure or check motion (host/model/pieces.h). A run with energies measures, and so copies, in each step. Both runs
// must agree to the last bit, in whatever is read between steps: by stages, by checks of motion beside rigid blocks,
// where halves part, and by users.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "scene/read_scene.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "support.h"

namespace quoin {
namespace {

struct Case {
  const char* name;
  std::string scene;
  std::vector<std::string> overrides;
};

void PrintTo(const Case& of, std::ostream* out) { *out << of.name; }

class VelocitiesInLanes : public ::testing::TestWithParam<Case> {};

TEST_P(VelocitiesInLanes, AreThoseOfARunThatCopiesThemInEachStep) {
  const auto scene_with = [](const char* energy) {
    std::vector<std::string> overrides = GetParam().overrides;
    overrides.push_back(energy);
    return read_scene(GetParam().scene, overrides);
  };
  Simulation each(scene_with("output.energy=true"), 2), seldom(scene_with("output.energy=false"), 2);
  Observer nobody;
  long without_copy = 0;
  bool goes_on = true;
  for (int part = 0; goes_on && part < 300; ++part) {
    constexpr long kSteps = 7;  // seldom the step of a row
    goes_on = each.run_stage(nobody, kSteps);
    ASSERT_EQ(seldom.run_stage(nobody, kSteps), goes_on);
    ASSERT_EQ(seldom.step(), each.step()) << "another end of the stage";
    const blocks::Model& m = *seldom.large_motion();
    without_copy += !m.copies_velocities;
    ASSERT_EQ(seldom.hash(), each.hash()) << "step " << each.step();
    for (int block = 0; block < static_cast<int>(m.blocks.size()); ++block) {
      ASSERT_EQ(block_displacement(seldom, block), block_displacement(each, block)) << block;
      ASSERT_EQ(block_velocity(seldom, block), block_velocity(each, block)) << block;
    }
  }
  EXPECT_GT(without_copy, 3) << "parts that end with a step that copied nothing";
}

const std::string kTurned = QUOIN_HOST_TESTS "/turned_wall.toml";

INSTANTIATE_TEST_SUITE_P(
    Kinds, VelocitiesInLanes,
    ::testing::Values(Case{"Turned", kTurned, {"stage.pull.duration=0.02", "stage.pull.record_interval=100"}},
                      Case{"TurnedWithADeformableMonitor",
                           kTurned,
                           {"stage.pull.monitor=wall/2/0/b", "stage.pull.displacement=2e-5", "stage.pull.duration=1.0",
                            "stage.pull.record_interval=100"}},
                      Case{"HalvesThatPart", QUOIN_HOST_TESTS "/halves_part.toml", {"solver.large_motion=always"}}),
    [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace quoin
