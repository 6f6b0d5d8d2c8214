// monitors.csv: several monitors against the columns of the history, and the tilt of a column in closed form.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <map>
#include <sstream>
#include <thread>

#include "program.h"

namespace {

using testing::HasSubstr;

class Monitors : public Cli {
 protected:
  // Returns two blocks on each other, with elastic joints, on a ground with 1 m/s2 along x from 0.1 s of the stage on.
  std::string scene(const std::string& monitors, double duration = 0.4) const {
    const std::string path = (folder_ / "scene.toml").string();
    std::ofstream(path) << R"(
[materials.stone]
density = 2000.0
[joints.joint]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e8
[[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -0.2, -1], size = [2, 0.2, 2] }
[[block]]
name = "low"
material = "stone"
box = { lower = [-0.2, 0, -0.2], size = [0.4, 0.5, 0.4] }
[[block]]
name = "high"
material = "stone"
box = { lower = [-0.2, 0.5, -0.2], size = [0.4, 0.5, 0.4] }
[[stage]]
name = "weight"
gravity = [0.0, -9.81, 0.0]
ramp_time = 0.05
duration = 0.1
)"
                        << fmt::format(R"(
[[stage]]
name = "shake"
duration = {}
ground_motion = {{ direction = [1, 0, 0], time = [0, 0.1, 9], acceleration = [0, 1, 1] }}
)",
                                       duration)
                        << monitors << "[output]\nmonitor = \"high\"\nframes = 0\nplots = false\n";
    return path;
  }
  // Returns the columns of a table by name.
  std::map<std::string, std::vector<double>> columns(const fs::path& file) const {
    std::stringstream stream(read_all(file));
    std::vector<std::string> names;
    std::map<std::string, std::vector<double>> all;
    for (std::string line; std::getline(stream, line);) {
      std::vector<std::string> cells;
      std::stringstream of_line(line);
      for (std::string cell; std::getline(of_line, cell, ',');) cells.push_back(cell);
      if (names.empty()) {
        names = cells;
        continue;
      }
      for (std::size_t i = 0; i < cells.size(); ++i) {
        char* end = nullptr;
        const double value = std::strtod(cells[i].c_str(), &end);
        all[names.at(i)].push_back(end == cells[i].c_str() ? NAN : value);
      }
    }
    return all;
  }
  // Runs a scene to its end in one folder. In another one the run is killed after its first checkpoint.
  void run_whole_and_killed() {
    const std::string path = scene(both_, 3.0);
    ASSERT_EQ(quoin({"run", path, "--out", whole_.string(), "--threads", "1", "--checkpoint-every", "0"}), 0) << error_;
    const pid_t child =
        start({QUOIN_PROGRAM, "run", path, "--out", cut_.string(), "--threads", "1", "--checkpoint-every", "0.005"});
    while (!fs::exists(cut_ / "checkpoint.bin") && waitpid(child, nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    kill(child, SIGKILL);
    finish(child);
  }
  void expect_resumed_as_whole() {
    ASSERT_EQ(quoin({"run", "--resume", cut_.string(), "--threads", "1"}), 0) << error_;
    EXPECT_THAT(error_, HasSubstr("resumed at step"));
    for (const char* file : {"monitors.csv", "monitors.json", "history.csv"})
      EXPECT_EQ(read_all(cut_ / file), read_all(whole_ / file)) << file;
  }
  void SetUp() override { Cli::SetUp(), whole_ = folder_ / "whole", cut_ = folder_ / "cut"; }
  fs::path whole_, cut_;
  const std::string both_ =
      "[[monitor]]\nname = \"foot\"\nblock = \"low\"\n[[monitor]]\nname = \"top\"\nblock = \"high\"\nbelow = \"foot\"\n"
      "[[monitor]]\nname = \"corner\"\nblock = \"high\"\npoint = [0.3, 1.2, 0.3]\n";
};

TEST_F(Monitors, AgreeWithTheHistoryAndWithEachOther) {
  ASSERT_EQ(quoin({"run", scene(both_), "--out", out(), "--threads", "1"}), 0) << error_;
  auto history = columns(fs::path(out()) / "history.csv"), monitors = columns(fs::path(out()) / "monitors.csv");
  ASSERT_EQ(history["time_s"].size(), monitors["time_s"].size());
  const std::size_t last = monitors["time_s"].size() - 1;
  const auto& time = monitors["time_s"];
  double ringing = 0.0;
  for (std::size_t i = 0; i <= last; ++i) {
    EXPECT_EQ(history["time_s"][i], time[i]);
    // The mean of the corners of a rigid box is its centre, but for rotation, of second order.
    EXPECT_NEAR(monitors["top_dx_m"][i], history["monitor_dx_m"][i], 1e-9);
    EXPECT_NEAR(monitors["top_relative_dx_m"][i], history["monitor_relative_dx_m"][i], 1e-9);
    EXPECT_EQ(monitors["ground_dx_m"][i], history["ground_dx_m"][i]);
    EXPECT_NEAR(monitors["top_drift_x"][i], (monitors["top_dx_m"][i] - monitors["foot_dx_m"][i]) / 0.5, 1e-12);
    if (i > 0) ringing = std::max(ringing, std::abs(monitors["top_relative_ax_m_s2"][i]));
  }
  // 0.4 s after the weight: v = 0.05 + 0.3 m/s, half a step before, and 1 m/s2.
  EXPECT_NEAR(monitors["ground_vx_m_s"][last], 0.35, 1e-3);
  EXPECT_NEAR(monitors["ground_ax_m_s2"][last], 1.0, 1e-3);
  EXPECT_NEAR(monitors["top_ax_m_s2"][last] - monitors["ground_ax_m_s2"][last], monitors["top_relative_ax_m_s2"][last],
              1e-9);
  EXPECT_GT(ringing, 0.01) << "nothing swings";
  // The corner is at (0.2, 1, 0.2): it moves with the block and, by the tilt, further.
  EXPECT_LT(monitors["corner_relative_dx_m"][last], monitors["top_relative_dx_m"][last]);
  const auto json = nlohmann::json::parse(read_all(fs::path(out()) / "monitors.json"));
  EXPECT_EQ(json["top"]["residual"]["top_relative_dx_m"], monitors["top_relative_dx_m"][last]);
  EXPECT_GE(json["top"]["largest"]["top_relative_dx_m"].get<double>(), std::abs(monitors["top_relative_dx_m"][last]));
}

// drifts.png has the extremes of the columns of drifts over the heights of the centres, 0.25 and 0.75 m. base_shear.png
// has the columns of the history while the ground moves.
TEST_F(Monitors, PicturesOfEarthquakesHaveTheirNumbers) {
  if (std::system("gnuplot --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no gnuplot";
  ASSERT_EQ(quoin({"run", scene(both_), "--out", out(), "--threads", "1", "--histories", "--svg", "--set",
                   "output.plots=true"}),
            0)
      << error_;
  auto history = columns(fs::path(out()) / "history.csv"), monitors = columns(fs::path(out()) / "monitors.csv");
  const auto numbers_in = [&](const char* file) {
    std::vector<double> numbers;
    std::stringstream stream(read_all(fs::path(out()) / "plots" / file));
    std::string head;
    std::getline(stream, head);
    for (double x = 0.0; stream >> x;) numbers.push_back(x);
    return numbers;
  };
  const auto& drift = monitors["top_drift_x"];
  const double least = std::min(0.0, *std::min_element(drift.begin(), drift.end()));
  const double most = std::max(0.0, *std::max_element(drift.begin(), drift.end()));
  EXPECT_GT(most - least, 1e-9) << "nothing has moved";
  const std::vector<double> drawn = numbers_in("drifts.dat");
  const std::vector<double> expected{100 * least, 0.25, 100 * least, 0.75, 100 * most, 0.25, 100 * most, 0.75};
  ASSERT_EQ(drawn.size(), expected.size()) << "along x alone: nothing moves along z";
  for (std::size_t i = 0; i < drawn.size(); ++i) EXPECT_NEAR(drawn[i], expected[i], 1e-6 * std::abs(expected[i]));

  const std::vector<double> loop = numbers_in("base_shear.dat");
  std::size_t k = 0;
  for (std::size_t i = 0; i < history["time_s"].size(); ++i) {
    if (history["stage"][i] != 2) continue;
    ASSERT_LT(k + 1, loop.size());
    const double moved = 1e3 * history["monitor_relative_dx_m"][i], shear = history["base_shear_x_N"][i] / 1e3;
    EXPECT_NEAR(loop[k], moved, 1e-6 * std::abs(moved));
    EXPECT_NEAR(loop[k + 1], shear, 1e-6 * std::abs(shear));
    k += 3;
  }
  EXPECT_EQ(k, loop.size());
  for (const char* picture : {"drifts.png", "drifts.svg", "base_shear.png", "base_shear.svg"})
    EXPECT_TRUE(fs::exists(fs::path(out()) / picture)) << picture;
}

TEST_F(Monitors, DriftsAtOneHeightAreRefused) {
  const std::string level = scene(both_ +
                                  "[[monitor]]\nname = \"level\"\nblock = \"low\"\nbelow = \"top\"\n"
                                  "[[monitor]]\nname = \"same\"\nblock = \"high\"\nbelow = \"top\"\n");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"check", level}, {"run", level, "--out", out()}}) {
    EXPECT_EQ(quoin(command), 3) << error_;
    EXPECT_THAT(error_, HasSubstr("monitor same: below = \"top\", at the same height y = 0.75 m"));
  }
}

TEST_F(Monitors, GoOnWhereAKilledRunWasLeft) {
  ASSERT_NO_FATAL_FAILURE(run_whole_and_killed());
  expect_resumed_as_whole();
}

TEST_F(Monitors, DoNotStayWhereALaterRunHasNone) {
  ASSERT_EQ(quoin({"run", scene(both_), "--out", out(), "--threads", "1"}), 0) << error_;
  ASSERT_TRUE(fs::exists(fs::path(out()) / "monitors.csv"));
  ASSERT_EQ(quoin({"run", scene(""), "--out", out(), "--threads", "1"}), 0) << error_;
  for (const char* file : {"monitors.csv", "monitors.json"}) EXPECT_FALSE(fs::exists(fs::path(out()) / file)) << file;
}

// A run that is killed while it starts leaves monitors.csv cut short, under the name of its partial file.
TEST_F(Monitors, GoOnAfterARunThatWasKilledWhileItStarted) {
  ASSERT_NO_FATAL_FAILURE(run_whole_and_killed());
  int parts = 0;
  for (const auto& entry : fs::directory_iterator(cut_)) {
    if (!entry.path().filename().string().starts_with("monitors.csv.")) continue;
    fs::resize_file(entry.path(), fs::file_size(entry.path()) / 4);
    ++parts;
  }
  ASSERT_EQ(parts, 1);
  expect_resumed_as_whole();
}

// Monitors on the lattice, and in large motion after a promotion by ground motion.
TEST_F(Monitors, FollowAWallFromTheLatticeIntoLargeMotion) {
  const std::string path = (folder_ / "wall.toml").string();
  std::ofstream(path) << read_all(small_) << R"(
[[stage]]
name = "quake"
duration = 0.004
ground_motion = { direction = [1, 0, 0], time = [0, 1], acceleration = [2, 2] }
[[monitor]]
name = "beam"
block = "top_beam"
)";
  ASSERT_EQ(quoin({"run", path, "--out", out(), "--threads", "1", "--set", "stage.shear.displacement=0.00005"}), 0)
      << error_;
  auto history = columns(fs::path(out()) / "history.csv"), monitors = columns(fs::path(out()) / "monitors.csv");
  const std::size_t rows = monitors["time_s"].size();
  ASSERT_EQ(history["time_s"].size(), rows);
  std::size_t sheared = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (history["stage"][i] != 2) continue;
    ++sheared;
    EXPECT_NEAR(monitors["beam_dx_m"][i], history["displacement_m"][i], 1e-12);
  }
  EXPECT_GT(sheared, 10u);
  EXPECT_NEAR(monitors["ground_vx_m_s"].back(), 2.0 * 0.004, 1e-4);
  EXPECT_NEAR(monitors["beam_dx_m"].back() - monitors["ground_dx_m"].back(), monitors["beam_relative_dx_m"].back(),
              1e-15);
}

// In all stages of a building the history has the displacement of its last floor, here of two rigid beams, up and along
// x. Forces are those on the ground, at rest weight and load.
TEST_F(Monitors, OfAFloorAgreeWithTheHistoryOfTheRoof) {
  const std::string path = (folder_ / "building.toml").string();
  std::ofstream(path) << read_all(QUOIN_CLI_TESTS "/../host/small_building.toml")
                      << "[[monitor]]\nname = \"roof\"\nblock = \"floor_1\"\n[output]\nframes = 0\nplots = false\n";
  for (const std::string motion : {"never", "always"}) {
    std::vector<std::string> words{"run", path, "--out", out(), "--threads", "1"};
    for (const char* setting : {"stage.push.displacement=0.002", "stage.push.record_interval=50",
                                "stage.weight.equilibrium_ratio=1e-3", "stage.weight.duration=0.5"})
      words.insert(words.end(), {"--set", setting});
    words.insert(words.end(), {"--set", "solver.large_motion=" + motion});
    ASSERT_EQ(quoin(words), 0) << error_;
    auto history = columns(fs::path(out()) / "history.csv"), monitors = columns(fs::path(out()) / "monitors.csv");
    const std::size_t rows = monitors["time_s"].size();
    ASSERT_EQ(history["time_s"].size(), rows);
    std::size_t of_weight = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      if (history["stage"][i] == 1) of_weight = i;
      // Corners of a beam that turns in large motion move by its rotation squared, about 1e-6, times 0.2 m further.
      EXPECT_NEAR(monitors["roof_dx_m"][i], history["displacement_m"][i], 1e-7) << motion;
      EXPECT_NEAR(monitors["roof_dy_m"][i], history["vertical_displacement_m"][i], 1e-7) << motion;
    }
    ASSERT_GT(of_weight, 10U);
    EXPECT_LT(history["vertical_displacement_m"][of_weight], -1e-5) << motion;
    // Two walls and their corner without the window, 0.25 m thick and 1.28 m high; 20 kN on the floor.
    const double weight = 9.81 * 1750.0 * 0.25 * ((1.4 + 0.6 + 0.25) * 1.28 - 0.4 * 0.48);
    EXPECT_NEAR(history["vertical_force_N"][of_weight], 20e3 + weight, 5.0) << motion;
    // The stage ends by the displacement of the roof from the mean of the floors, of which there is one.
    EXPECT_NEAR(history["displacement_m"].back() - history["displacement_m"][of_weight], 0.002, 1e-5) << motion;
    EXPECT_GT(history["horizontal_force_N"].back(), 100.0) << motion;
  }
}

// The force of a building that is shaken across its walls has the sign of one that is pushed along them: that on the
// ground.
TEST_F(Monitors, OfABuildingShakenAlongZ) {
  const std::string path = (folder_ / "shaken.toml").string();
  const std::string building = read_all(QUOIN_CLI_TESTS "/../host/small_building.toml");
  std::ofstream(path) << building.substr(0, building.find("[[stage]]\nname = \"push\"")) << R"(
[[stage]]
name = "shake"
duration = 0.02
record_interval = 20
ground_motion = { direction = [0, 0, 1], time = [0, 1], acceleration = [1, 1] }
[output]
frames = 0
plots = false
)";
  ASSERT_EQ(quoin({"run", path, "--out", out(), "--threads", "1"}), 0) << error_;
  auto history = columns(fs::path(out()) / "history.csv");
  double largest = 0.0;
  for (std::size_t i = 0; i < history["stage"].size(); ++i) {
    if (history["stage"][i] != 2) continue;
    EXPECT_EQ(history["horizontal_force_N"][i], history["base_shear_z_N"][i]) << i;
    EXPECT_EQ(history["displacement_m"][i], history["monitor_dz_m"][i]) << i;
    largest = std::max(largest, std::abs(history["base_shear_z_N"][i]));
  }
  EXPECT_GT(largest, 100.0);
}

TEST_F(Monitors, OfNobodyAreRefusedByCheckToo) {
  ASSERT_EQ(quoin({"check", scene(both_)}), 0) << error_;
  EXPECT_EQ(quoin({"check", scene("[[monitor]]\nname = \"top\"\nblock = \"hihg\"\n")}), 3);
  EXPECT_THAT(error_, HasSubstr("no block is called 'hihg', did you mean 'high'?"));
}

// Many blocks with equal controls share a name on the lattice, and had lost their own: monitors of them were refused.
TEST_F(Monitors, OfOneOfManyFixedBlocksHaveItsName) {
  const std::string path = (folder_ / "many.toml").string();
  std::ofstream file(path);
  file << R"(
[materials.stone]
density = 2000.0
[joints.joint]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e8
)";
  constexpr int kFixed = 14;
  for (int i = 0; i < kFixed; ++i)
    file << fmt::format(
        "[[block]]\nname = \"ground{}\"\nmaterial = \"stone\"\nfixed = true\n"
        "box = {{ lower = [{}, -1, 0], size = [1, 1, 1] }}\n",
        i, 2 * i);
  file << R"(
[[block]]
name = "cube"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[monitor]]
name = "supported"
block = "ground3"
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
duration = 0.02
monitor = "cube"
[output]
frames = 0
plots = false
)";
  file.close();
  ASSERT_EQ(quoin({"run", path, "--out", out()}), 0) << error_;
  EXPECT_THAT(out_, testing::Not(HasSubstr("general kernels")));
  const auto rows = columns(fs::path(out()) / "monitors.csv");
  for (const double u : rows.at("supported_dy_m")) EXPECT_EQ(u, 0.0);
}

TEST_F(Monitors, SayWhatIsWrong) {
  const auto fault = [&](const std::string& monitors) {
    EXPECT_EQ(quoin({"run", scene(monitors), "--out", out()}), 3) << monitors;
    return error_;
  };
  EXPECT_THAT(fault("[[monitor]]\nname = \"a b\"\nblock = \"low\"\n"), HasSubstr("letters, digits, _ and -"));
  EXPECT_THAT(fault("[[monitor]]\nname = \"a\"\nblock = \"lower\"\n"), HasSubstr("lower"));
  EXPECT_THAT(fault("[[monitor]]\nname = \"a\"\nblock = \"low\"\nbelow = \"b\"\n"), HasSubstr("given before this one"));
  EXPECT_THAT(fault("[[monitor]]\nname = \"ground\"\nblock = \"low\"\n"), HasSubstr("not \"ground\""));
  EXPECT_THAT(
      fault("[[monitor]]\nname = \"a\"\nblock = \"low\"\n[[monitor]]\nname = \"a_relative\"\nblock = \"low\"\n"),
      HasSubstr("not NAME_relative beside NAME"));
}

}  // namespace
