// Runs that are killed and resumed have results that are equal, byte for byte, to those of an uninterrupted run. Runs
// that cannot be resumed are refused with the reason.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <map>
#include <random>
#include <thread>

#include "program.h"

namespace {

using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

class Resume : public Cli {
 protected:
  // Kills and resumes the run at random times until it is complete. Returns the number of resumes from a checkpoint.
  int run_and_kill(const std::vector<std::string>& scene, const fs::path& out, double seconds, std::mt19937& random) {
    std::vector<std::string> first{QUOIN_PROGRAM, "run"};
    first.insert(first.end(), scene.begin(), scene.end());
    first.insert(first.end(), {"--out", out.string()});
    std::vector<std::string> again{QUOIN_PROGRAM, "run", "--resume", out.string()};
    for (auto* words : {&first, &again}) words->insert(words->end(), {"--threads", "1", "--checkpoint-every", "0.005"});
    int from_checkpoint = 0;
    for (int kills = 0;; ++kills) {
      const pid_t child = start(fs::exists(out / "run.json") ? again : first);
      if (kills == 0) {
        while (!fs::exists(out / "checkpoint.bin") && waitpid(child, nullptr, WNOHANG) == 0)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      if (kills < 3)
        std::this_thread::sleep_for(
            std::chrono::duration<double>(std::uniform_real_distribution<>(0.0, seconds)(random)));
      if (kills < 3) kill(child, SIGKILL);
      const int code = finish(child);
      if (error_.find("resumed at step") != std::string::npos) ++from_checkpoint;
      if (kills < 3) continue;
      EXPECT_EQ(code, 0) << error_;
      return from_checkpoint;
    }
  }

  static std::string without_times(const fs::path& summary) {
    auto json = nlohmann::json::parse(read_all(summary));
    json.erase("wall_clock_s");
    return json.dump(2);
  }

  void expect_same_after_kills(const std::vector<std::string>& scene) {
    std::vector<std::string> whole{"run"};
    whole.insert(whole.end(), scene.begin(), scene.end());
    whole.insert(whole.end(), {"--out", out(), "--threads", "1", "--checkpoint-every", "0"});
    const auto begin = Clock::now();
    ASSERT_EQ(quoin(whole), 0) << error_;
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    std::mt19937 random(20260);
    int from_checkpoint = 0;
    for (int i = 0; i < 5; ++i) {
      const fs::path killed = folder_ / ("killed" + std::to_string(i));
      from_checkpoint += run_and_kill(scene, killed, 0.7 * seconds, random);
      EXPECT_EQ(read_all(killed / "history.csv"), read_all(fs::path(out()) / "history.csv"));
      EXPECT_EQ(without_times(killed / "summary.json"), without_times(fs::path(out()) / "summary.json"));
      for (const auto& entry : fs::directory_iterator(out())) {
        const std::string extension = entry.path().extension();
        if (extension != ".vtu" && extension != ".vtp" && extension != ".pvd") continue;
        const fs::path same = killed / entry.path().filename();
        EXPECT_TRUE(read_all(same) == read_all(entry.path())) << same;
      }
      EXPECT_FALSE(fs::exists(killed / "checkpoint.bin"));
    }
    EXPECT_GT(from_checkpoint, 0);
  }

  // Starts a long run of the small wall and stops it soon, with a checkpoint.
  void stop_soon(std::vector<std::string> more) {
    more.insert(more.begin(),
                {QUOIN_PROGRAM, "run", scene_, "--out", out(), "--threads", "1", "--set", "output.plots=false"});
    const pid_t child = start(more);
    while (!fs::exists(out() + "/run.json") && waitpid(child, nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    kill(child, SIGINT);
    ASSERT_EQ(finish(child), 130) << error_;
  }
  void expect_refused(const std::string& reason) {
    EXPECT_EQ(quoin({"run", "--resume", out()}, [] { alarm(60); }), 3);  // ends a run that is not refused
    EXPECT_THAT(error_, HasSubstr(reason));
  }
  std::string checkpoint() const { return out() + "/checkpoint.bin"; }
  void write_checkpoint(const std::string& bytes) const { std::ofstream(checkpoint(), std::ios::binary) << bytes; }

  void SetUp() override {
    Cli::SetUp();
    scene_ = (folder_ / "wall.toml").string();
    fs::copy_file(small_, scene_);
  }
  std::string scene_;
};

TEST_F(Resume, KilledWallsEndAsIfLeftAlone) {
  // Long enough to be killed during the run. Frames follow damage too.
  expect_same_after_kills({small_, "--set", "stage.shear.velocity=0.01", "--set", "output.frames_at_damage=0.02"});
}

TEST_F(Resume, KilledBuildingsEndAsIfLeftAlone) {
  expect_same_after_kills({QUOIN_CLI_TESTS "/../host/small_building.toml", "--set", "stage.push.displacement=0.004",
                           "--set", "stage.weight.equilibrium_ratio=0.1", "--set", "output.plots=false"});
}

TEST_F(Resume, KilledCollapsesEndAsIfLeftAlone) {
  expect_same_after_kills({QUOIN_SCENES "/arch.toml", "--set", "stage.push.collapse.start=0.36", "--set",
                           "output.energy=true", "--set", "output.plots=false"});
}

// Also the damping of modes, which is computed at the begin of the shake.
TEST_F(Resume, KilledShakesEndAsIfLeftAlone) {
  std::ofstream(scene_, std::ios::app) << R"(
[[stage]]
name = "shake"
duration = 0.02
ground_motion = { direction = [1, 0, 0], time = [0, 1], acceleration = [2, 2] }
)";
  expect_same_after_kills({scene_, "--set", "stage.shear.displacement=0.00002", "--set", "output.plots=false"});
  const auto summary = nlohmann::json::parse(read_all(fs::path(out()) / "summary.json"));
  EXPECT_GT(summary["damping_of_modes"]["shake"].size(), 0U) << summary["damping_of_modes"];
}

// Frames after a resume had other bytes than those before, and pictures that the run was asked for were not drawn.
TEST_F(Resume, OptionsOfResultsStay) {
  stop_soon({"--set", "output.plots=true", "--set", "output.frames=20", "--histories", "--compressed", "--set",
             "stage.shear.velocity=0.0003"});
  ASSERT_EQ(quoin({"run", "--resume", out(), "--threads", "1"}), 0) << error_;
  EXPECT_THAT(read_all(out() + "/blocks_0020.vtu"), HasSubstr("compressor="));
  EXPECT_TRUE(fs::exists(out() + "/histories.png") || error_.find("gnuplot") != std::string::npos) << error_;
}

// A run killed after its summary, and before its end, was "done": what came later was never written.
TEST_F(Resume, ARunKilledAtItsEndIsCompleted) {
  stop_soon({"--set", "output.end_state=true", "--set", "stage.shear.velocity=0.0003"});
  const std::string last = read_all(checkpoint());
  ASSERT_EQ(quoin({"run", "--resume", out(), "--threads", "1"}), 0) << error_;
  const std::string end_state = read_all(out() + "/end_state.bin");
  fs::remove(out() + "/end_state.bin");
  write_checkpoint(last);
  ASSERT_EQ(quoin({"run", "--resume", out(), "--threads", "1"}), 0) << error_;
  EXPECT_TRUE(read_all(out() + "/end_state.bin") == end_state);
  EXPECT_FALSE(fs::exists(checkpoint()));
}

// Dowels, soil on a face, a tie through a block, and a moving load on it.
TEST_F(Resume, MembersAndAMovingLoadGoOn) {
  const fs::path scene = folder_ / "members.toml";
  std::ofstream(scene) << dry_stone(35) << R"([solver]
damping = "viscous"
mass_damping = 10.0
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [-3, -1, -1], size = [8, 1, 3] }
[[block]]
name = "wall"
material = "stone"
box = { lower = [0, 0, 0], size = [1, 2, 1] }
[[dowel]]
point = [0.2, 0, 0.5]
direction = [0, 1, 0]
axial_stiffness = 1e8
shear_stiffness = 1e7
yield_force = 1e4
yield_shear = 1e3
[[fill]]
block = "wall"
towards = [1, 0, 0]
surface = [0, 2, 0]
unit_weight = 18e3
friction_angle = 30
stiffness = 1e7
[[tie]]
from = { block = "base", point = [-2, 0, 0.5] }
through = [{ block = "wall", point = [0, 1.5, 0.5] }]
to = { block = "base", point = [-2.5, 0, 0.5] }
area = 1e-4
young_modulus = 2e11
yield_stress = 1e8
[[stage]]
gravity = [0, -9.81, 0]
ramp_time = 0.2
duration = 100.0
moving_load = { from = [0.1, 3, 0.5], to = [0.9, 3, 0.5], force = [5e3, -1e4, 0] }
[output]
frames = 4
plots = false
)";
  expect_same_after_kills({scene.string()});
}

TEST_F(Resume, FinishedRunsAreLeftAsTheyAre) {
  ASSERT_EQ(run_small(), 0) << error_;
  std::map<std::string, std::string> before;
  for (const auto& entry : fs::directory_iterator(out()))
    if (entry.is_regular_file()) before[entry.path().string()] = read_all(entry.path());
  EXPECT_EQ(quoin({"run", "--resume", out()}), 0);
  EXPECT_THAT(out_, HasSubstr("the run is done"));
  for (const auto& [path, bytes] : before) EXPECT_TRUE(read_all(path) == bytes) << path;
}

TEST_F(Resume, WithoutCheckpointsARunStartsAnew) {
  ASSERT_EQ(run_small(), 0) << error_;
  const std::string history = read_all(out() + "/history.csv");
  fs::remove(out() + "/summary.json");  // as after a run that is killed before its end
  EXPECT_EQ(quoin({"run", "--resume", out()}), 0) << error_;
  EXPECT_THAT(error_, HasSubstr("from the start"));
  EXPECT_EQ(read_all(out() + "/history.csv"), history);
  EXPECT_EQ(summary()["status"], "done");
}

// Resuming with another scene is refused also without a checkpoint.
TEST_F(Resume, WithoutCheckpointsOtherScenesAreRefusedToo) {
  ASSERT_EQ(quoin({"run", scene_, "--out", out(), "--threads", "1"}), 0) << error_;
  fs::remove(out() + "/summary.json");
  std::ofstream(scene_, std::ios::app) << "# another one\n";
  expect_refused("is of another scene than the run was begun with");
  fs::copy_file(small_, scene_, fs::copy_options::overwrite_existing);
  EXPECT_EQ(quoin({"run", "--resume", out()}), 0) << error_;
}

TEST_F(Resume, RefusesWhatIsNoRun) {
  expect_refused("no such folder");
  fs::create_directories(out());
  expect_refused("no run was begun here");
  std::ofstream(out() + "/run.json") << "{\"scene\": 3}";
  expect_refused("is not the record of a run");
  EXPECT_EQ(quoin({"run", small_, "--resume", out()}), 2);
  EXPECT_EQ(quoin({"run"}), 2);
  EXPECT_EQ(quoin({"run", small_, "--checkpoint-every", "-1"}), 2);
}

// Any change of a file that the scene names is refused, also of a word without effect on the model.
TEST_F(Resume, RefusesMeshesThatHaveChanged) {
  const auto write_mesh = [&](const char* remark) {
    std::ofstream(folder_ / "cube.off") << "OFF\n"
                                        << remark << "8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n"
                                        << "1 1 1\n4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n";
  };
  write_mesh("");
  std::ofstream(scene_) << "[materials.stone]\nyoung_modulus = 1e10\npoisson_ratio = 0.2\ndensity = 1000.0\n"
                           "[joints.dry]\nlaw = \"coulomb_slip\"\ninitial_state = \"dry\"\nnormal_stiffness = 1e8\n"
                           "shear_stiffness = 1e8\nfriction_angle = 35.0\n[[block]]\nname = \"base\"\nmaterial = "
                           "\"stone\"\nfixed = true\nbox = { lower = [0, -1, 0], size = [1, 1, 1] }\n[[block]]\nname = "
                           "\"cube\"\nmaterial = \"stone\"\nmesh = \"cube.off\"\n[[stage]]\nname = \"shear\"\n"
                           "gravity = [0, -9.81, 0]\nduration = 1e6\n[output]\nframes = 0\n";
  stop_soon({});
  write_mesh("# another one\n");
  expect_refused("is of another scene");
}

TEST_F(Resume, RefusesCheckpointsOfAnotherSceneLawOrMachine) {
  const std::string law = (folder_ / "my_law.so").string();
  fs::copy_file(fs::path(QUOIN_PROGRAM).parent_path() / "laws" / "fracture_energy.so", law);
  stop_soon({"--set", "stage.shear.velocity=1e-6", "--law", law});
  const std::string good = read_all(checkpoint());
  ASSERT_GT(good.size(), 1000u);

  const auto with_byte = [&](std::size_t at, char byte) {
    std::string bytes = good;
    bytes[at] = byte;
    return bytes;
  };
  write_checkpoint(with_byte(0, 'X'));
  expect_refused("is no checkpoint of quoin");
  std::string swapped = good;
  std::reverse(swapped.begin() + 8, swapped.begin() + 12);
  write_checkpoint(swapped);
  expect_refused("word order");
  write_checkpoint(with_byte(12, 99));
  expect_refused("version 99 of the format");
  write_checkpoint(with_byte(17, 77));
  expect_refused("words of another size");
  write_checkpoint(with_byte(good.size() / 2, static_cast<char>(good[good.size() / 2] + 1)));
  expect_refused("its checksum does not fit");
  write_checkpoint(good.substr(0, good.size() - 100));
  expect_refused("is damaged");
  write_checkpoint(good.substr(0, 20));
  expect_refused("cut short");

  // A valid checkpoint of another version of the program: version and checksum are changed.
  std::string other = good;
  const std::string what = "version of quoin";
  other[other.find(what) + what.size() + 8] = '9';
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (std::size_t i = 40; i < other.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, other.data() + i, std::min<std::size_t>(8, other.size() - i));
    hash = (hash ^ word) * 0x100000001b3u;
    hash ^= hash >> 29;
  }
  std::memcpy(other.data() + 32, &hash, sizeof hash);
  write_checkpoint(other);
  expect_refused("is of another version of quoin (9.");

  write_checkpoint(good);
  const std::string scene = read_all(scene_);
  std::ofstream(scene_, std::ios::app) << "# another one\n";
  expect_refused("is of another scene");
  std::ofstream(scene_) << scene;
  std::ofstream(law, std::ios::app) << "rebuilt";
  expect_refused("is of another library of the law");
  EXPECT_EQ(read_all(checkpoint()), good);  // a refusal does not change the checkpoint
}

TEST_F(Resume, NumbersOfTheHistoryReadBackToTheSameDouble) {
  ASSERT_EQ(run_small(), 0) << error_;
  std::ifstream history(out() + "/history.csv");
  std::string line, last;
  while (std::getline(history, line)) last = line;
  // The time of the last row is the number of steps times the time step, which the summary has with all digits.
  std::istringstream fields(last);
  std::string field;
  for (int i = 0; i < 4; ++i) std::getline(fields, field, ',');
  EXPECT_EQ(std::stod(field), summary()["simulated_time_s"].get<double>());
}

}  // namespace
