// Runs that start from the end of other runs are bitwise identical to one run of all stages, also if they are killed
// and repeated. Scenes that cannot start there are refused with the reason.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

#include "program.h"

namespace {

using ::testing::HasSubstr;
using ::testing::Not;

class Start : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    whole_ = (folder_ / "whole.toml").string(), first_ = (folder_ / "first.toml").string();
    second_ = (folder_ / "second.toml").string();
    const std::string text = read_all(small_), damage = "[[damage]]\nto = [0.3, 0.01, 1]\nxi = 0.5\n";
    const std::size_t shear = text.rfind("[[stage]]"), output = text.find("[output]");
    std::ofstream(whole_) << text << damage;
    std::ofstream(first_) << text.substr(0, shear) << text.substr(output) << damage;
    std::ofstream(second_) << "start = \"first\"\n" << text;
    ASSERT_EQ(run(first_, "first", {"--set", "output.end_state=true"}), 0) << error_;
  }
  std::vector<std::string> words(const std::string& scene, const std::string& name,
                                 const std::vector<std::string>& more) const {
    std::vector<std::string> all{
        QUOIN_PROGRAM,       "run", scene, "--out", (folder_ / name).string(), "--threads", "1", "--set",
        "output.plots=false"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  int run(const std::string& scene, const std::string& name, const std::vector<std::string>& more = {}) {
    return finish(start(words(scene, name, more)));
  }
  std::string file(const std::string& run, const std::string& name) const { return read_all(folder_ / run / name); }
  // Returns the rows of a stage.
  std::string driven(const std::string& name, const char* stage = "2,") const {
    std::stringstream stream(file(name, "history.csv"));
    std::string rows;
    for (std::string line; std::getline(stream, line);)
      if (line.starts_with(stage)) rows += line + "\n";
    return rows;
  }

  std::string whole_, first_, second_;
};

TEST_F(Start, GoesOnWithTheBitsOfOneRun) {
  ASSERT_EQ(run(whole_, "whole"), 0) << error_;
  ASSERT_EQ(run(second_, "second"), 0) << error_;
  EXPECT_EQ(driven("second"), driven("whole"));
  EXPECT_GT(driven("second").size(), 1000u);
  for (const char* name : {"blocks_0003.vtu", "joints_0003.vtu"})
    EXPECT_TRUE(file("second", name) == file("whole", name)) << name;

  // Repeated, from the same start.
  EXPECT_EQ(quoin({"run", "--again", (folder_ / "second").string(), "--out", out()}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("the bits agree"));
}

// A beam that moves at the end of the first run continues. The third stage begins with its velocity, on the lattice and
// in the general kernels.
TEST_F(Start, AMovingBeamMovesOn) {
  const std::string on =
      "[[stage]]\nname = \"on\"\nkind = \"shear\"\nvelocity = 0.03\nramp_time = 0.01\ndisplacement = 0.0003\n";
  const std::string text = read_all(small_);
  const std::size_t output = text.find("[output]");
  for (const char* kernels : {"automatic", "general"}) {
    const std::vector<std::string> with{"--set", std::string("solver.kernels=") + kernels};
    std::ofstream(whole_) << text.substr(0, output) << on << text.substr(output);
    std::ofstream(first_) << text;
    std::ofstream(second_) << "start = \"moving\"\n" << text.substr(0, output) << on << text.substr(output);
    ASSERT_EQ(run(first_, "moving", {with[0], with[1], "--set", "output.end_state=true"}), 0) << error_;
    ASSERT_EQ(run(whole_, "whole", with), 0) << error_;
    ASSERT_EQ(run(second_, "second", with), 0) << error_;
    EXPECT_EQ(driven("second", "3,"), driven("whole", "3,")) << kernels;
    EXPECT_GT(driven("second", "3,").size(), 1000u);
    EXPECT_THAT(error_, Not(HasSubstr("energies do not balance")));
    for (const char* run : {"moving", "whole", "second"}) fs::remove_all(folder_ / run);
  }
}

// A stage after the start may swap laws: states there are those of the laws before. It was refused.
TEST_F(Start, ALaterStageSwapsLaws) {
  for (const char* kernels : {"automatic", "general"}) {
    const std::vector<std::string> of_first{"--set", std::string("solver.kernels=") + kernels},
        with{of_first[0], of_first[1], "--set", "stage.shear.law=\"coulomb_slip\""};
    ASSERT_EQ(run(first_, "first", {of_first[0], of_first[1], "--set", "output.end_state=true"}), 0) << error_;
    ASSERT_EQ(run(whole_, "whole", with), 0) << error_;
    ASSERT_EQ(run(second_, "second", with), 0) << error_;
    EXPECT_EQ(driven("second"), driven("whole")) << kernels;
    EXPECT_GT(driven("second").size(), 1000u);
  }
  EXPECT_EQ(run(second_, "other", {"--set", "stage.precompression.law=\"coulomb_slip\""}), 3);
  EXPECT_THAT(error_, HasSubstr("other laws or keys (library of the law 'fracture_energy'; here library of the law "
                                "'coulomb_slip')"));
}

// The stiffness of a whiffletree counts from the start of the run that has it. In large motion the time step of the
// state went on, 3 times too long. The run blew up, with a peak of 0.00 kN, and no error.
TEST_F(Start, AWhiffletreeSetsTheTimeStepInLargeMotion) {
  const std::string text = read_all(QUOIN_TESTS "/host/small_building.toml");
  const std::string before = text.substr(0, text.find("[[stage]]"));
  const std::string weight = "[[stage]]\nname = \"weight\"\nkind = \"weight\"\nduration = 0.02\n";
  const std::string push =
      "[[stage]]\nname = \"push\"\nkind = \"push\"\nvelocity = 0.02\nstiffness = 1e11\ndisplacement = 0.0001\n";
  std::ofstream(whole_) << before << weight << push;
  std::ofstream(first_) << before << weight;
  std::ofstream(second_) << "start = \"soft\"\n" << before << weight << push;
  const std::vector<std::string> always{"--set", "solver.large_motion=always"};
  ASSERT_EQ(run(first_, "soft", {always[0], always[1], "--set", "output.end_state=true"}), 0) << error_;
  ASSERT_EQ(run(whole_, "whole", always), 0) << error_;
  ASSERT_EQ(run(second_, "second", always), 0) << error_;
  const auto number = [&](const std::string& name, const std::string& key) {
    const std::string summary = file(name, "summary.json");
    return std::stod(summary.substr(summary.find("\"" + key + "\": ") + key.size() + 4));
  };
  EXPECT_LT(number("second", "time_step_s"), 0.5 * number("soft", "time_step_s"));
  EXPECT_NEAR(number("second", "time_step_s"), number("whole", "time_step_s"), 1e-9 * number("whole", "time_step_s"));
  const double peak = number("whole", "peak_horizontal_force_N");
  ASSERT_GT(peak, 1e3);
  // The first run has taken its first stage in longer steps.
  EXPECT_NEAR(number("second", "peak_horizontal_force_N"), peak, 0.01 * peak);
}

TEST_F(Start, KilledRunsGoOn) {
  const std::vector<std::string> slowly{"--set",
                                        "stage.shear.velocity=0.002"};  // long enough to be killed during the run
  ASSERT_EQ(run(second_, "second", slowly), 0) << error_;
  // Before the first checkpoint, and after it.
  for (const char* every : {"0", "0.005"}) {
    fs::remove_all(folder_ / "killed");
    const pid_t child = start(words(second_, "killed", {slowly[0], slowly[1], "--checkpoint-every", every}));
    const fs::path sign = folder_ / "killed" / (every[1] ? "checkpoint.bin" : "run.json");
    while (!fs::exists(sign) && waitpid(child, nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    kill(child, SIGKILL);
    ASSERT_EQ(finish(child), 128 + SIGKILL) << every;
    ASSERT_EQ(quoin({"run", "--resume", (folder_ / "killed").string(), "--threads", "1"}), 0) << error_;
    EXPECT_EQ(file("killed", "history.csv"), file("second", "history.csv")) << every;
  }
}

// Joint rules, contacts and members are settings too. They were ignored, or taken over in mid-run. 1 and 1.0 are equal.
TEST_F(Start, OtherJointRulesContactsAndMembersAreRefused) {
  const std::string text = R"([materials.stone]
density = 2000.0
[joints.rough]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 1e9
friction_angle = 30
[joints.smooth]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 1e9
friction_angle = 5
[[joint_rule]]
between = ["ground", "cube"]
family = "rough"
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -1, 0], size = [3, 1, 1] }
[[block]]
name = "cube"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[spring]]
name = "beside"
block = "cube"
normal = [1, 0, 0]
normal_stiffness = 1e6
shear_stiffness = 0.0
tension = true
[output]
frames = 0
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.05
duration = 0.1
)",
                    last = "[[stage]]\nname = \"on\"\nduration = 0.1\n";
  std::ofstream(first_) << text;
  std::ofstream(second_) << "start = \"first\"\n" << text << last;
  ASSERT_EQ(run(first_, "first", {"--set", "output.end_state=true"}), 0) << error_;
  EXPECT_EQ(run(second_, "second", {"--set", "spring.1.normal_stiffness=1000000"}), 0) << error_;
  for (const auto& [setting, reason] : {std::pair("joint_rule.1.family=\"smooth\"", "another joint_rule"),
                                        {"contact.skin=0.02", "another contact"},
                                        {"block.2.fixed=true", "another list of fixed blocks"},
                                        {"spring.1.normal_stiffness=2e6", "another spring"}}) {
    EXPECT_EQ(run(second_, "other", {"--set", setting}), 3) << setting;
    EXPECT_THAT(error_, HasSubstr(reason)) << setting;
  }
}

// A stage that ends at a displacement ends elsewhere where another body or axis is monitored.
TEST_F(Start, AnotherMonitorOfTheFirstStagesIsRefused) {
  const std::string text = read_all(small_), before = text.substr(0, text.find("[[stage]]"));
  const auto stage = [](const char* monitor) {
    return fmt::format(
        "[[stage]]\nname = \"move\"\nkind = \"custom\"\ndisplacement = 1e-6\nmonitor = \"top_beam\"\ndirection = "
        "\"{}\"\ncontrol = [{{ body = \"bottom_beam\", velocity = [0, 0, 0] }}, {{ body = \"top_beam\", velocity = "
        "[0.01, 0.01, 0] }}]\n",
        monitor);
  };
  std::ofstream(first_) << before << stage("x");
  ASSERT_EQ(run(first_, "first", {"--set", "output.end_state=true"}), 0) << error_;
  const std::string more = "[[stage]]\nname = \"next\"\nkind = \"custom\"\nduration = 1e-4\n";
  std::ofstream(second_) << "start = \"first\"\n" << before << stage("x") << more;
  EXPECT_EQ(run(second_, "second"), 0) << error_;
  std::ofstream(second_) << "start = \"first\"\n" << before << stage("y") << more;
  EXPECT_EQ(run(second_, "other"), 3);
  EXPECT_THAT(error_, HasSubstr("monitor top_beam along y"));
}

// Another correlation draws other properties. It was taken.
TEST_F(Start, AnotherCorrelationOfJointsIsRefused) {
  const auto with = [](const std::string& value) {
    std::vector<std::string> words;
    for (const char* property : {"cohesion", "tensile_strength"})
      words.insert(words.end(),
                   {"--set", std::string("joints.mortar.") + property + "={distribution='normal',mean=0.3e6,cov=0.1}"});
    words.insert(words.end(), {"--set", "joints.mortar.correlation=[['cohesion','tensile_strength'," + value + "]]"});
    return words;
  };
  std::vector<std::string> first = with("0.8");
  first.insert(first.end(), {"--set", "output.end_state=true"});
  ASSERT_EQ(run(first_, "first", first), 0) << error_;
  EXPECT_EQ(run(second_, "same", with("0.8")), 0) << error_;
  EXPECT_EQ(run(second_, "other", with("-0.8")), 3);
  EXPECT_THAT(error_, HasSubstr("set of materials, joints"));
}

TEST_F(Start, WhatDoesNotFitIsRefusedWithTheReason) {
  const auto refused = [&](const std::vector<std::string>& more, const std::string& reason) {
    EXPECT_EQ(run(second_, "other", more), 3) << reason;
    EXPECT_THAT(error_, HasSubstr(reason));
    std::vector<std::string> check{"check", second_};
    check.insert(check.end(), more.begin(), more.end());
    EXPECT_EQ(quoin(check), 3) << reason;
    EXPECT_THAT(error_, HasSubstr(reason));
  };
  refused({"--set", "joints.mortar.tensile_strength=0.1e6"}, "set of materials, joints");
  refused({"--set", "materials.brick.density=1800"}, "set of materials, joints");
  refused({"--set", "stage.precompression.pressure=0.4e6"}, "version of stage 'precompression'");
  refused({"--set", "stage.precompression.equilibrium_ratio=0.01"}, "version of stage 'precompression'");
  refused({"--set", "wall.courses=3"}, "arrangement of blocks");
  refused({"--set", "wall.unit=[0.22,0.0626,0.1]"}, "arrangement of blocks");
  // Different settings are refused with both values.
  refused({"--set", "solver.local_damping=0.4"}, "another solver.local_damping (0.3; here 0.4)");
  refused({"--set", "solver.time_step_fraction=0.5"}, "another solver.time_step_fraction (0.86; here 0.5)");
  refused({"--set", "solver.settling_damping=0.6"}, "solver.settling_damping");
  // Energies are sums from the first stage on; after a run without energies they would be incomplete.
  refused({"--set", "output.energy=true"}, "another output.energy (false; here true)");
  refused({"--set", "start=\"nowhere\""}, "does not exist");
  refused({"--law", "coulomb_slip"}, "other laws");
  EXPECT_EQ(quoin({"check", second_}), 0) << error_;
  // Start from the output folder of the run itself, whose results would be removed before they are read.
  const std::string state = file("first", "end_state.bin");
  EXPECT_EQ(run(second_, "first"), 3);
  EXPECT_THAT(error_, HasSubstr("give another one"));
  EXPECT_TRUE(file("first", "end_state.bin") == state);
}

}  // namespace
