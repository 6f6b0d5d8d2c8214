// Every action of a stage (host/scene/actions): its reader, messages, text and page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <sstream>

#include "one_block.h"
#include "scene/actions/action.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// A sample of each action, and the sample with another number.
const std::map<std::string, std::array<std::string, 2>> kSamples = {
    {"ground_motion",
     {"{ direction = [1, 0, 0], time = [0, 1], acceleration = [0, 1] }",
      "{ direction = [1, 0, 0], time = [0, 1], acceleration = [0, 2] }"}},
    {"collapse", {"{ start = 0.1 }", "{ start = 0.2 }"}},
    {"moving_load",
     {"{ from = [0, 2, 0], to = [1, 2, 0], force = [0, -1, 0] }",
      "{ from = [0, 2, 0], to = [1, 2, 0], force = [0, -2, 0] }"}},
    {"force",
     {"[{ block = 'block', point = [0, 0, 0], force = [1, 0, 0] }]",
      "[{ block = 'block', point = [0, 0, 0], force = [2, 0, 0] }]"}},
    {"pressure",
     {"[{ block = 'block', normal = [1, 0, 0], pressure = 1 }]",
      "[{ block = 'block', normal = [1, 0, 0], pressure = 2 }]"}},
};

Stage read(const std::string& key, const std::string& value) {
  return read_scene_text(kOneBlock + key + " = " + value + "\n", "scene.toml").stages.front();
}

TEST(StageActions, AreReadNamedAndToldApart) {
  EXPECT_EQ(beyond_lattice(Stage{}), "");
  EXPECT_THAT(action_texts(Stage{}), ElementsAre());
  for (const StageAction& action : kStageActions) {
    ASSERT_TRUE(kSamples.contains(action.key)) << action.key << ": without a sample";
    const auto& [one, another] = kSamples.at(action.key);
    const Stage stage = read(action.key, one);
    EXPECT_EQ(beyond_lattice(stage), action.has);
    ASSERT_EQ(action_texts(stage).size(), 1u) << action.key;
    // Different texts, so that a checkpoint of one is refused by a run of the other.
    EXPECT_THAT(action_texts(read(action.key, another)), Not(ElementsAre(action_texts(stage).front()))) << action.key;
  }
}

TEST(StageActions, ThePageHasTheirKeys) {
  std::ifstream file(QUOIN_SCENES "/BLOCKS.md");
  std::stringstream page;
  page << file.rdbuf();
  for (const StageAction& action : kStageActions) {
    const std::string key = action.key;
    EXPECT_THAT(page.str(), AnyOf(HasSubstr("| " + key + " |"), HasSubstr("| [[stage." + key + "]]")));
  }
}

}  // namespace
}  // namespace quoin
