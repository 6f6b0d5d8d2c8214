// `quoin rest` and `quoin modes --state` through their command line.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>

#include "program.h"

namespace {

using ::testing::HasSubstr;

class Rest : public Cli {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(folder_ / "scene.toml") << text;
    return (folder_ / "scene.toml").string();
  }
  nlohmann::json json(const std::string& folder, const char* name) const {
    return nlohmann::json::parse(read_all(fs::path(folder) / name));
  }
};

// A rigid cube of 1 m and 1800 kg on a dry bed, with a horizontal force of 0.6 of its weight at its centre. The
// resultant is 0.3 m from the centre, and the bed is closed over 3 (0.5 - 0.3) m; by its last point, over 10 mm more.
constexpr const char* kCube = R"(
[materials.stone]
density = 1800.0
[joints.bed]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 4e8
friction_angle = 45.0
[contact]
point_spacing = 0.02
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [-1, -1, -1], size = [3, 1, 3] }
[[block]]
name = "cube"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[output]
frames = 0
plots = false
[[stage]]
name = "push"
gravity = [0, -9.81, 0]
ramp_time = 0.1
duration = 1.0
)";
std::string pushed(double force) {
  return kCube + fmt::format("[[stage.force]]\nblock = \"cube\"\npoint = [0.5, 0.5, 0.5]\nforce = [{}, 0, 0]\n", force);
}
constexpr double kWeight = 1800.0 * 9.81;  // N

// Frequencies of six degrees of freedom on the closed part of the bed, by integrals over it.
TEST_F(Rest, OpenJointsHaveNoStiffness) {
  const std::string scene = write(pushed(0.6 * kWeight)), rest = (folder_ / "rest").string();
  ASSERT_EQ(quoin({"rest", scene, "--out", rest}), 0) << error_;
  EXPECT_EQ(json(rest, "summary.json")["status"], "done");
  EXPECT_TRUE(fs::exists(fs::path(rest) / "end_state.bin"));
  const auto frequencies = [&](const std::string& state) {
    EXPECT_EQ(quoin({"modes", scene, "--state", state, "--out", out()}), 0) << error_;
    return json(out(), "modes.json")["frequencies_Hz"].get<std::vector<double>>();
  };
  const std::vector<double> whole = frequencies("undamaged"), weight = frequencies("weight"), end = frequencies(rest);
  ASSERT_EQ(whole.size(), 6u);
  ASSERT_EQ(weight.size(), 6u);
  ASSERT_EQ(end.size(), 6u);
  const std::array all{45.6245, 45.6245, 75.0264, 118.6271, 137.9383, 137.9384},
      open{23.0094, 32.7155, 51.3318, 80.5369, 110.9506, 117.0822};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(whole[i], all[i], 0.001 * all[i]) << i;
    EXPECT_NEAR(weight[i], open[i], 0.005 * open[i]) << i;
    EXPECT_NEAR(end[i], weight[i], 1e-6 * weight[i]) << i;
  }
}

// With a stiff joint in shear the cube rocks about the centre of its base. Its weight at half of its height reduces the
// rocking stiffness 1e7/12.
TEST_F(Rest, WeightTakesFromTheStiffnessOfRocking) {
  const std::string scene = write(kCube);
  const auto lowest = [&](const std::string& state) {
    EXPECT_EQ(quoin({"modes", scene, "--state", state, "--set", "joints.bed.normal_stiffness=1e7", "--set",
                     "joints.bed.shear_stiffness=1e11", "--out", out()}),
              0)
        << error_;
    return json(out(), "modes.json")["frequencies_Hz"][0].get<double>();
  };
  const double before = lowest("undamaged"), after = lowest("weight");
  EXPECT_NEAR(after / before, std::sqrt(1.0 - kWeight * 0.5 / (1e7 / 12.0)), 5e-4);
}

// A rigid block of 1 x 2 x 0.8 m on a joint of 5e7 and 2e7 Pa/m, with a load of 700 kN along its axis.
std::string loaded_block(const std::string& load, const std::string& keys = "") {
  return "[materials.stone]\nyoung_modulus = 1e12\npoisson_ratio = 0.2\ndensity = 2000.0\n[joints.dry]\nlaw = "
         "\"coulomb_slip\"\ninitial_state = \"dry\"\nnormal_stiffness = 5e7\nshear_stiffness = 2e7\nfriction_angle = "
         "35.0\n[contact]\ncubic_points = true\n[[block]]\nname = \"base\"\nmaterial = \"stone\"\nfixed = true\nbox = "
         "{ lower = [-1, -1, -1], size = [3, 1, 3] }\n[[block]]\nname = \"b\"\nmaterial = \"stone\"\nbox = { lower = "
         "[0, 0, 0], size = [1, 2, 0.8] }\n" +
         keys +
         "[output]\nframes = 0\nplots = false\n[[stage]]\nname = \"weight\"\ngravity = [0, -9.81, 0]\nramp_time = "
         "0.1\nduration = 0.5\n" +
         load;
}
std::string force_at(double y, double force) {
  return fmt::format("[[stage.force]]\nblock = \"b\"\npoint = [0.5, {}, 0.4]\nforce = [0, {}, 0]\n", y, -force);
}
constexpr const char* kPressed = "[[stage.pressure]]\nblock = \"b\"\nnormal = [0, 1, 0]\npressure = 875e3\n";
constexpr double kLoad = 700e3, kBlockWeight = 3200.0 * 9.81;

// Lowest frequency of sway u of the centre, 1 m above the joint, and rocking theta about the short axis. Stiffness:
// ks A, ks A - turning/2; kn I + ks A - (W + P) 1 m - moment. A force on an arm above the centre has P times that arm
// as moment. A pressure has P as `turning`, the force for a unit of rotation.
double lowest_of_block(double load, double moment, double turning) {
  const double m = kBlockWeight / 9.81, inertia = m * (0.8 * 0.8 + 2.0 * 2.0) / 12.0, ks = 2e7 * 0.8;
  const double a = ks / m, c = (ks - 0.5 * turning) / std::sqrt(m * inertia),
               b = (5e7 * std::pow(0.8, 3) / 12.0 + ks - kBlockWeight - load - moment) / inertia;
  return std::sqrt(0.5 * (a + b) - std::hypot(0.5 * (a - b), c)) / (2.0 * M_PI);
}

// Tolerance: the points integrate the joint exactly; 1e-4 is for equilibrium of the state of rest.
TEST_F(Rest, LoadsHaveAnArmFromTheCentreOfARigidBlock) {
  const std::string rest = (folder_ / "rest").string();
  for (const auto& [load, expected] : {std::pair{force_at(2.0, kLoad), lowest_of_block(kLoad, kLoad, 0.0)},
                                       {force_at(1.0, kLoad), lowest_of_block(kLoad, 0.0, 0.0)},
                                       {force_at(0.0, kLoad), lowest_of_block(kLoad, -kLoad, 0.0)},
                                       {std::string(kPressed), lowest_of_block(kLoad, 0.0, kLoad)}}) {
    const std::string scene = write(loaded_block(load));
    ASSERT_EQ(quoin({"rest", scene, "--out", rest}), 0) << error_;
    for (const std::string& state : {std::string("weight"), rest}) {
      ASSERT_EQ(quoin({"modes", scene, "--state", state, "--out", out()}), 0) << error_;
      EXPECT_NEAR(json(out(), "modes.json")["frequencies_Hz"][0].get<double>(), expected, 1e-4 * expected)
          << load << state;
    }
  }
}

// It buckles at a load P of which kn I - (W + 2 P) 1 m is 0, 1.05 MN.
TEST_F(Rest, ABlockThatBucklesIsNotStable) {
  EXPECT_EQ(quoin({"modes", write(loaded_block(force_at(2.0, 1.0e6))), "--state", "weight", "--out", out()}), 0);
  EXPECT_EQ(quoin({"modes", write(loaded_block(force_at(2.0, 1.1e6))), "--state", "weight", "--out", out()}), 5);
  EXPECT_THAT(error_, HasSubstr("not stable"));
}

// The zones are stiff. Their joint has other points than a rigid block's, so the change by the pressure is compared.
TEST_F(Rest, PressureFollowsAFaceOfADeformableBlock) {
  const auto lowest = [&](const std::string& load) {
    const std::string scene = write(loaded_block(load, "rigid = false\nzone_edge = 0.25\n"));
    EXPECT_EQ(quoin({"modes", scene, "--state", "weight", "--out", out()}), 0) << error_;
    return json(out(), "modes.json")["frequencies_Hz"][0].get<double>();
  };
  const double expected = lowest_of_block(kLoad, 0.0, kLoad) / lowest_of_block(0.0, 0.0, 0.0);
  EXPECT_NEAR(lowest(kPressed) / lowest(""), expected, 1e-3);
  EXPECT_NEAR(expected, 1.0136, 1e-4);
}

TEST_F(Rest, WhatIsWrongIsSaid) {
  const std::string scene = write(kCube);
  EXPECT_EQ(quoin({"rest", scene, "--stage", "nowhere", "--out", out()}), 3);
  EXPECT_THAT(error_, HasSubstr("no such stage; the scene has: push"));
  EXPECT_EQ(quoin({"rest", scene, "--set", "stage.push.gravity=[0, 0, 0]", "--out", out()}), 3);
  EXPECT_THAT(error_, HasSubstr("no stage has a weight or a load"));
  EXPECT_EQ(quoin({"modes", scene, "--state", (folder_ / "none").string()}), 3);
}

// Another scene with the same first stage can start from a state at rest.
TEST_F(Rest, AnotherSceneBeginsThere) {
  const std::string scene = QUOIN_SCENES "/arch.toml", rest = (folder_ / "rest").string();
  ASSERT_EQ(quoin({"rest", scene, "--out", rest, "--set", "output.plots=false"}), 0) << error_;
  EXPECT_EQ(json(rest, "summary.json")["status"], "done");
  EXPECT_EQ(quoin({"run", "--again", rest, "--out", (folder_ / "again").string()}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("the bits agree"));
}

// The scene is shaken in the general kernels, and its weight alone could be on the lattice. The state was refused for
// another stage.
TEST_F(Rest, AShakeBeginsThere) {
  std::string cube = kCube;
  cube.erase(cube.find("[contact]"), 31);  // on the lattice, blocks have the points of corners
  const std::string scene = cube +
                            "[[stage]]\nname = \"shake\"\nduration = 0.02\nmonitor = \"cube\"\n"
                            "ground_motion = { direction = [1, 0, 0], time = [0, 0.02], acceleration = [1, 1] }\n";
  const std::string rest = (folder_ / "rest").string();
  ASSERT_EQ(quoin({"rest", write(scene), "--out", rest}), 0) << error_;
  std::string begins_there = scene;
  begins_there.replace(begins_there.find("ramp_time = 0.1\nduration = 1.0\n"), 31, "kind = \"rest\"\n");
  EXPECT_EQ(quoin({"run", write("start = \"" + rest + "\"\n" + begins_there), "--out", out()}), 0) << error_;
  // A state that was on the lattice is refused with the remedy.
  const std::string alone = begins_there.substr(0, begins_there.find("[[stage]]\nname = \"shake\""));
  ASSERT_EQ(quoin({"run", write(alone), "--out", rest, "--set", "output.end_state=true"}), 0) << error_;
  EXPECT_EQ(quoin({"run", write("start = \"" + rest + "\"\n" + begins_there), "--out", out()}), 3);
  EXPECT_THAT(error_, HasSubstr("solver.kernels = \"general\""));
}

// Nothing moves, so nothing sets the time step: `quoin check` crashed.
TEST_F(Rest, FixedBlocksAloneAreChecked) {
  std::string scene = kCube;
  scene.replace(scene.find("name = \"cube\""), 13, "name = \"cube\"\nfixed = true");
  EXPECT_EQ(quoin({"check", write(scene)}), 0) << error_;
}

}  // namespace
