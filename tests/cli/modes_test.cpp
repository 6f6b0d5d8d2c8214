// `quoin modes` through its command line.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "program.h"
#include "results/read_vtu.h"

namespace {

using ::testing::HasSubstr;

class Modes : public Cli {
 protected:
  nlohmann::json modes(const std::string& scene) {
    EXPECT_EQ(quoin({"modes", QUOIN_SCENES "/" + scene, "--out", out()}), 0) << error_;
    return nlohmann::json::parse(read_all(fs::path(out()) / "modes.json"));
  }
};

TEST_F(Modes, OneFrequencyOfZeroIsRefused) {
  EXPECT_EQ(quoin({"modes", QUOIN_SCENES "/arch.toml", "--at", "5", "0"}), 3);
  EXPECT_THAT(error_, HasSubstr("damping at 5 and 0 Hz; allowed: above 0"));
}

// A rigid block of weight W and height h stands on an elastic joint while kn b^3 d/12 > W h/2. Just below, its first
// frequency was 0, of a mode "without stiffness".
TEST_F(Modes, AStateThatIsNotStableIsRefused) {
  const double b = 0.5, h = 4.0, d = 0.8, density = 2000.0;
  const double limit = 9.81 * density * b * h * d * h / 2.0 / (b * b * b * d / 12.0);
  const std::string path = (folder_ / "tall.toml").string();
  std::ofstream(path) << fmt::format(R"([materials.stone]
density = {}
[joints.bed]
law = "elastic"
normal_stiffness = 1e7
shear_stiffness = 1e8
[contact]
cubic_points = true
[[block]]
material = "stone"
fixed = true
box = {{ lower = [-1, -1, -1], size = [3, 1, 3] }}
[[block]]
material = "stone"
box = {{ lower = [0, 0, 0], size = [{}, {}, {}] }}
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
duration = 1
)",
                                     density, b, h, d);
  const auto at = [&](double share) {
    return quoin(
        {"modes", path, "--state", "weight", "--set", fmt::format("joints.bed.normal_stiffness={}", share * limit)});
  };
  EXPECT_EQ(at(1.02), 0) << error_;
  EXPECT_EQ(at(0.98), 5);
  EXPECT_THAT(error_, HasSubstr("the state is not stable"));
}

// A wall of bricks and an equal wall of blocks have equal frequencies.
TEST_F(Modes, WallsOfBricksAndOfBlocksHaveTheSameFrequencies) {
  const nlohmann::json bricks = modes("solid_wall_030.toml"), blocks = modes("solid_wall_030_blocks.toml");
  ASSERT_EQ(bricks["frequencies_Hz"].size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) {
    const double f = bricks["frequencies_Hz"][i];
    EXPECT_NEAR(blocks["frequencies_Hz"][i], f, 1e-6 * f);
    if (i > 0) {
      EXPECT_GE(f, bricks["frequencies_Hz"][i - 1]);
    }
  }
  EXPECT_EQ(bricks["zero_modes"], 0);
}

TEST_F(Modes, EveryKindOfSceneHasThem) {
  for (const char* scene : {"arch.toml", "mixed.toml", "cube_wall_10.toml", "ispra_isp1.toml"}) {
    const nlohmann::json found = modes(scene);
    EXPECT_EQ(found["frequencies_Hz"].size(), 10u) << scene;
    EXPECT_GT(found["frequencies_Hz"][0], 0.0) << scene;
    EXPECT_GT(found["rayleigh"]["alpha_per_s"], 0.0) << scene;
    const quoin::VtuFile file(fs::path(out()) / "modes.vtu");
    const auto shape = file.values_of<float>(fmt::format("mode_1_{:.4g}_Hz", found["frequencies_Hz"][0].get<double>()));
    double largest = 0.0;
    for (std::size_t i = 0; i + 2 < shape.size(); i += 3)
      largest = std::max(largest, std::hypot(static_cast<double>(shape[i]), static_cast<double>(shape[i + 1]),
                                             static_cast<double>(shape[i + 2])));
    EXPECT_NEAR(largest, 1.0, 1e-6) << scene;
  }
}

// The ground of a wall that is shaken is that of its other stages: modes had none in the stage of the shake.
TEST_F(Modes, StagesThatShakeAWallStandOnTheGround) {
  const std::string path = (folder_ / "shaken.toml").string();
  std::ofstream(path) << read_all(small_) << R"(
[[stage]]
name = "shake"
duration = 0.01
ground_motion = { direction = [1, 0, 0], time = [0, 1], acceleration = [0, 1] }
)";
  for (const std::string state : {"undamaged", "weight"}) {
    std::vector<std::string> words{"modes", path, "--stage", "shake", "--out", out(), "--state", state};
    if (state == "weight") words.insert(words.end(), {"--set", "stage.shake.gravity=[0, -9.81, 0]"});
    ASSERT_EQ(quoin(words), 0) << error_;
    const auto found = nlohmann::json::parse(read_all(fs::path(out()) / "modes.json"));
    EXPECT_GT(found["frequencies_Hz"][0], 1.0) << state;
    EXPECT_THAT(found["supports"].dump(), HasSubstr("bottom_beam")) << state;
  }
  // The end of a run has supports of its own. The option had no effect, a name of no stage neither.
  EXPECT_EQ(quoin({"modes", path, "--stage", "shake", "--state", "out/of_a_run"}), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("--stage shake"), HasSubstr("remove --stage")));
}

// A table of velocities replaces the fixity of a deformable block too. Held along all axes it is a fixed one; free
// along x the pair moves along x without stiffness. For the undamaged scene the table did not count. For a state it
// counted beside the fixity.
TEST_F(Modes, DeformableBlocksAreHeldAsTheirTableSays) {
  const auto found = [&](const std::string& of_base, const std::string& velocity, const std::string& state) {
    const std::string path = (folder_ / "pair.toml").string();
    std::ofstream(path) << fmt::format(R"([materials.stone]
density = 2000
young_modulus = 2e9
poisson_ratio = 0.2
[joints.bed]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e9
[[block]]
name = "base"
material = "stone"
rigid = false
divisions = [2, 2, 2]
{}
box = {{ lower = [0, -1, 0], size = [1, 1, 1] }}
[[block]]
material = "stone"
rigid = false
divisions = [2, 2, 2]
box = {{ lower = [0, 0, 0], size = [1, 1, 1] }}
[[stage]]
name = "s"
gravity = [0, -9.81, 0]
duration = 1e-3
{}
)",
                                       of_base, velocity);
    EXPECT_EQ(quoin({"modes", path, "--out", out(), "--state", state}), 0) << error_;
    return nlohmann::json::parse(read_all(fs::path(out()) / "modes.json"));
  };
  const auto table = [](const std::string& velocity) {
    return "[[stage.velocity]]\nblock = \"base\"\nvelocity = " + velocity;
  };
  for (const std::string state : {"undamaged", "weight"}) {
    const nlohmann::json fixed = found("fixed = true", "", state);
    EXPECT_EQ(fixed["zero_modes"], 0);
    for (const std::string of_base : {"", "fixed = true"}) {
      const nlohmann::json held = found(of_base, table("[0, 0, 0]"), state);
      EXPECT_EQ(held["supports"].dump(), R"(["base: x y z"])") << state;
      for (std::size_t i = 0; i < 6; ++i) {
        const double f = fixed["frequencies_Hz"][i];
        EXPECT_NEAR(held["frequencies_Hz"][i], f, 1e-6 * f) << state << of_base;
      }
    }
    const nlohmann::json slides = found("fixed = true", table("[\"free\", 0, 0]"), state);
    EXPECT_EQ(slides["zero_modes"], 1) << state;
    EXPECT_EQ(slides["supports"].dump(), R"(["base: y z"])") << state;
  }
}

// A user's own file of the name of a result was replaced without a word. Own results are replaced.
TEST_F(Modes, AFileOfTheUserIsKept) {
  const std::vector<std::string> command{"modes", QUOIN_SCENES "/arch.toml", "--count", "1", "--out", out()};
  fs::create_directories(out());
  std::ofstream(fs::path(out()) / "modes.json") << "mine";
  EXPECT_EQ(quoin(command), 3);
  EXPECT_THAT(error_, HasSubstr("has modes.json, which would be replaced"));
  EXPECT_EQ(read_all(fs::path(out()) / "modes.json"), "mine");
  fs::remove(fs::path(out()) / "modes.json");
  for (int i = 0; i < 2; ++i) EXPECT_EQ(quoin(command), 0) << error_;
}

TEST_F(Modes, WhatIsWrongIsSaid) {
  const std::string arch = QUOIN_SCENES "/arch.toml";
  EXPECT_EQ(quoin({"modes", arch, "--stage", "nowhere"}), 3);
  EXPECT_THAT(error_, HasSubstr("no such stage; the scene has: weight, push"));
  EXPECT_EQ(quoin({"modes", arch, "--ratios", "2", "0"}), 3);
  EXPECT_THAT(error_, HasSubstr("damping ratio"));
  EXPECT_EQ(quoin({"modes", arch, "--count", "0"}), 3);
}

}  // namespace
