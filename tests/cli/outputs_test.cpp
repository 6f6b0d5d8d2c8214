// Output of results: malicious names and titles, folders in use or with other files, and files that other tools read.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <map>
#include <set>
#include <sstream>
#include <thread>

#include "program.h"

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Outputs : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    fs::current_path(folder_);  // commands in titles would create files here
  }
  void TearDown() override {
    fs::current_path("/");
    Cli::TearDown();
  }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  // Returns two free blocks on a fixed one, for a few steps.
  std::string block_scene() const {
    return write("blocks.toml", R"(title = "two blocks"
[solver]
damping = "local"
[materials.stone]
young_modulus = 10e9
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e10
shear_stiffness = 0.5e10
friction_angle = 33.0
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [0, -0.2, 0], size = [1, 0.2, 0.2] }
[[dry_wall]]
name = "wall"
material = "stone"
courses = 1
units_per_course = 2
unit = [0.4, 0.2, 0.2]
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
duration = 0.001
[output]
frames = 2
)");
  }
  std::vector<std::string> results(const fs::path& folder) const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const std::string name = entry.path().lexically_relative(folder).generic_string();
      if (entry.is_regular_file() && !name.starts_with(".quoin-")) names.push_back(name);
    }
    return names;
  }
};

TEST_F(Outputs, TitlesAndFoldersRunNoCommands) {
  const fs::path canary = folder_ / "canary";
  const std::string touch = "touch " + canary.string();
  const std::vector<std::string> titles{"a `" + touch + "` b", "\\\"; system(\\\"" + touch + "\\\") #",
                                        "'.system('" + touch + "').'", "$(" + touch + ") _x^{2}@m",
                                        "a\\n!" + touch + "\\n"};
  const std::vector<std::string> folders{"`touch canary` b", "two\nlines", "\"q\" 'r'", "$(touch canary)",
                                         "\n!touch canary\n#"};
  const std::string blocks = block_scene();
  for (size_t i = 0; i < titles.size(); ++i) {
    SCOPED_TRACE(titles[i]);
    const fs::path out = folder_ / folders[i];
    const std::string title = "title=\"" + titles[i] + "\"";
    ASSERT_EQ(quoin({"run", small_, "--out", out.string(), "--threads", "1", "--set", title, "--set",
                     "stage.shear.displacement=1e-5", "--set", "output.frames=0"}),
              0)
        << error_;
    EXPECT_TRUE(fs::exists(out / "curve.png")) << error_;
    EXPECT_TRUE(fs::exists(out / "cracks.png")) << error_;
    ASSERT_EQ(quoin({"run", blocks, "--out", out.string(), "--set", title}), 0) << error_;
    EXPECT_TRUE(fs::exists(out / "mechanism.png")) << error_;
    EXPECT_FALSE(fs::exists(canary)) << "a command was run";
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) EXPECT_NE(entry.path().filename(), "canary");
}

// Where all blocks are fixed, as under a beam, the extent of what moves was none, and gnuplot failed.
TEST_F(Outputs, BlocksThatAreAllFixedAreDrawn) {
  const std::string scene = write("fixed.toml", R"([materials.m]
density = 2000.0
[joints.j]
law = "elastic"
normal_stiffness = 1e9
shear_stiffness = 1e9
[[block]]
name = "a"
material = "m"
fixed = true
box = { lower = [0, 0, 0], size = [1, 1, 1] }
[[block]]
name = "b"
material = "m"
fixed = true
box = { lower = [3, 0, 0], size = [1, 1, 1] }
[output]
frames = 0
[[stage]]
duration = 0.01
)");
  ASSERT_EQ(quoin({"run", scene, "--out", out()}), 0) << error_;
  for (const char* picture : {"cracks.png", "mechanism.png"})
    EXPECT_TRUE(fs::exists(fs::path(out()) / picture)) << picture << ": " << error_;
}

// File names are bytes; summary.json is UTF-8.
TEST_F(Outputs, TitlesAndNamesOfAnyBytesReachTheSummary) {
  const fs::path scene = folder_ / "b\xff.toml";
  fs::copy_file(small_, scene);
  ASSERT_EQ(quoin({"run", scene.string(), "--out", out(), "--set", "stage.shear.displacement=1e-5", "--set",
                   "title=a\xfe wall"}),
            0)
      << error_;
  EXPECT_EQ(summary()["title"], "a\uFFFD wall");
  EXPECT_EQ(summary()["scene"], (folder_ / "b\uFFFD.toml").string());
}

TEST_F(Outputs, PathTestsRunNoCommands) {
  const fs::path canary = folder_ / "canary";
  const std::string touch = "touch " + canary.string();
  for (const std::string& name :
       {std::string("it's `touch canary`\n$(touch canary)"), std::string("\";!touch canary;\"")}) {
    const std::string file =
        write(name + ".toml", "title = \"a `" + touch + "` \\\"; system(\\\"" + touch + "\\\") 'b' \\n!" + touch +
                                  "\\n\"\nlaw = \"elastic\"\n[properties]\nnormal_stiffness = 1e9\n"
                                  "shear_stiffness = 1e9\n[[point]]\ndn = -1e-6\nsteps = 5\n"
                                  "along = [\"sigma = kn*dn\"]\n");
    const fs::path plots = folder_ / (name + " plots");
    ASSERT_EQ(quoin({"path", file, "--plot", plots.string()}), 0) << error_;
    EXPECT_TRUE(fs::exists(plots / (name + ".png")));
  }
  for (const auto& entry : fs::recursive_directory_iterator(folder_)) EXPECT_NE(entry.path().filename(), "canary");
}

TEST_F(Outputs, ARunRemovesOnlyWhatTheLastOneWrote) {
  ASSERT_EQ(run_small({"--set", "stage.shear.displacement=1e-5"}), 0) << error_;
  std::ofstream(out() + "/notes.txt") << "mine";
  std::ofstream(out() + "/plots/mine.gp") << "mine";
  // A run of another scene without frames and pictures removes all files of the first run, and no files of the user.
  ASSERT_EQ(quoin({"run", block_scene(), "--out", out(), "--set", "output.frames=0", "--set", "output.plots=false"}), 0)
      << error_;
  std::vector<std::string> left = results(out());
  for (const std::string& name : left) EXPECT_THAT(name, Not(HasSubstr(".vtu"))) << name;
  for (const char* name : {"/cracks.png", "/curve.png", "/joints.pvd"}) EXPECT_FALSE(fs::exists(out() + name)) << name;
  EXPECT_EQ(read_all(out() + "/notes.txt"), "mine");
  EXPECT_EQ(read_all(out() + "/plots/mine.gp"), "mine");
}

// A folder without a run that has a file with the name of a result, for each kind of result.
TEST_F(Outputs, RefusesAFolderWithOtherThingsOfThoseNames) {
  ASSERT_EQ(run_small({"--set", "stage.shear.displacement=1e-5"}), 0) << error_;
  std::vector<std::string> names = results(out());
  ASSERT_EQ(quoin({"run", block_scene(), "--out", out()}), 0) << error_;
  for (const std::string& name : results(out())) names.push_back(name);
  names.insert(names.end(), {"plots/thesis.tex", "blocks_of_mine.vtu", "joints_of_mine.vtu", "report.html"});
  EXPECT_GT(names.size(), 25u);
  for (const std::string& name : names) {
    const fs::path folder = folder_ / "others", file = folder / name;
    fs::create_directories(file.parent_path());
    std::ofstream(file) << "mine";
    EXPECT_EQ(quoin({"run", small_, "--out", folder.string(), "--set", "stage.shear.displacement=1e-5", "--set",
                     "output.frames=0", "--set", "output.plots=false"}),
              3)
        << name;
    EXPECT_THAT(error_, AllOf(HasSubstr(folder.string()), HasSubstr(name.starts_with("plots/") ? "has plots" : name),
                              HasSubstr("choose another folder with --out")));
    EXPECT_EQ(read_all(file), "mine") << name;
    fs::remove_all(folder);
  }
}

// The page of the last run stayed beside the results of the next one, and a page of the user was overwritten.
TEST_F(Outputs, PagesAreThoseOfTheirRun) {
  const std::string page = out() + "/report.html";
  ASSERT_EQ(run_small({"--set", "stage.shear.displacement=1e-5"}), 0) << error_;
  if (quoin({"report", out()}) != 0) GTEST_SKIP() << "no three.js: " << error_;
  ASSERT_TRUE(fs::exists(page));
  ASSERT_EQ(quoin({"report", out()}), 0) << "again: " << error_;
  ASSERT_EQ(run_small({"--set", "stage.shear.displacement=2e-5"}), 0) << error_;
  EXPECT_FALSE(fs::exists(page));
  std::ofstream(page) << "mine";
  EXPECT_EQ(quoin({"report", out()}), 3);
  EXPECT_THAT(error_, HasSubstr("report.html: is no page of quoin"));
  EXPECT_EQ(read_all(page), "mine");
}

TEST_F(Outputs, TwoRunsDoNotShareAFolder) {
  const pid_t first = start({QUOIN_PROGRAM, "run", small_, "--out", out(), "--threads", "1", "--set",
                             "stage.shear.velocity=1e-6", "--set", "output.plots=false", "--set", "output.frames=0"});
  const auto begun = [&] { return fs::exists(out() + "/.quoin-manifest"); };
  for (int i = 0; i < 1200 && !begun(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  for (const std::string& scene : {small_, block_scene()}) {
    const pid_t second = fork();  // not by start(), which would overwrite the messages of the first run
    if (second == 0) {
      const int error = open((folder_ / "second").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(error, STDERR_FILENO);
      execl(QUOIN_PROGRAM, QUOIN_PROGRAM, "run", scene.c_str(), "--out", out().c_str(), nullptr);
      _exit(126);
    }
    int status = 0;
    waitpid(second, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 3) << scene;
    EXPECT_THAT(read_all(folder_ / "second"),
                AllOf(HasSubstr("in use by another run (process " + std::to_string(first)), HasSubstr("--out")));
  }
  kill(first, SIGKILL);  // its lock ends with it; its incomplete history does not exist
  finish(first);
  EXPECT_FALSE(fs::exists(out() + "/history.csv"));
  ASSERT_EQ(run_small({"--set", "stage.shear.displacement=1e-5", "--set", "output.plots=false"}), 0) << error_;
  for (const std::string& name : results(out())) EXPECT_THAT(name, Not(HasSubstr(".part"))) << "left by the first";
}

TEST_F(Outputs, NamesOfStagesDoNotTearTheHistory) {
  std::string text = read_all(small_);
  const std::string name = "name = \"shear\"";
  text.replace(text.find(name), name.size(), "name = \"a \\\"b\\\", c\\nd\"");
  ASSERT_EQ(quoin({"run", write("named.toml", text), "--out", out(), "--threads", "1", "--set",
                   "stage.2.displacement=1e-5", "--set", "output.plots=false", "--set", "output.frames=0"}),
            0)
      << error_;
  const std::string history = read_all(out() + "/history.csv");
  EXPECT_THAT(history, HasSubstr("\n2,\"a \"\"b\"\", c d\","));
}

// Runs on the lattice without ground motion had none.
TEST_F(Outputs, EnergiesAreInTheSummaryOfEveryRunThatHasThem) {
  for (const char* energy : {"true", "false"}) {
    ASSERT_EQ(run_small({"--set", std::string("output.energy=") + energy, "--set", "output.plots=false"}), 0) << error_;
    const nlohmann::json s = summary();
    EXPECT_EQ(s.contains("energy_J"), energy == std::string("true"));
    if (!s.contains("energy_J")) continue;
    const double damping = s["energy_J"]["damping"], joints = s["energy_J"]["dissipated"];
    EXPECT_GT(damping, 0.0);
    EXPECT_NEAR(s["energy_J"]["damping_share"], damping / (damping + joints), 1e-12);
    EXPECT_FALSE(s["energy_J"].contains("damping_share_in_earthquake"));
  }
}

// gnuplot fails at a file without a point.
TEST_F(Outputs, ARunWithoutARowSaysThatThereIsNothingToDraw) {
  std::string text = read_all(small_);
  const size_t stage = text.find("[[stage]]"), output = text.find("[output]");
  text.replace(stage, output - stage, "[[stage]]\nkind = \"rest\"\ngravity = [0, -9.81, 0]\n");
  EXPECT_EQ(quoin({"run", write("rest.toml", text), "--out", out(), "--histories", "--set", "wall.bottom_beam=false"}),
            5);
  EXPECT_THAT(error_, AllOf(HasSubstr("no curve.png: the history has no row, so there is nothing to draw"),
                            HasSubstr("no histories.png: the history has no row"), Not(HasSubstr("gnuplot failed"))));
}

// The third half cycle of equal amplitude has a smaller force than the first: the run reports the half cycle and the
// loss.
TEST_F(Outputs, AStopAtForceLossIsToldWithItsForces) {
  std::string text = read_all(small_);
  const size_t stage = text.find("[[stage]]\nname = \"shear\""), output = text.find("[output]");
  text.replace(stage, output - stage,
               "[[stage]]\nname = \"cycles\"\nkind = \"cycles\"\namplitudes = [2e-4]\ncycles = 3\nvelocity = 0.05\n"
               "ramp_time = 0.001\nstop_at_force_loss = 0.97\n");
  ASSERT_EQ(quoin({"run", write("cycles.toml", text), "--out", out(), "--set", "output.plots=false"}), 0) << error_;
  const auto stop = summary()["stopped_at_force_loss"][0];
  const double force = stop["force_N"], before = stop["largest_force_before_N"];
  EXPECT_EQ(stop["half_cycle"], 3);
  EXPECT_LT(force, 0.97 * before);
  EXPECT_THAT(error_, HasSubstr(fmt::format("half cycle 3 reached {:.2f} kN, {:.2f} of {:.2f} kN before", force / 1e3,
                                            force / before, before / 1e3)));
}

// Arrays of a VTU file with one appended block of raw data, as the program writes it. Reads VTK's format without VTK.
class Vtu {
 public:
  explicit Vtu(const fs::path& file) : text_(read_all(file)) {
    const std::string mark = "<AppendedData encoding=\"raw\">\n_";
    data_ = text_.find(mark) + mark.size();
  }
  template <class T>
  std::vector<T> array(const std::string& name) const {
    const size_t at = text_.find("Name=\"" + name + "\"");
    if (at > data_) {
      ADD_FAILURE() << "no array " << name;
      return {};
    }
    const std::string mark = "offset=\"";
    const size_t place = data_ + std::stoul(text_.substr(text_.find(mark, at) + mark.size(), 20));
    std::uint64_t bytes = 0;
    std::memcpy(&bytes, text_.data() + place, sizeof bytes);
    std::vector<T> values(bytes / sizeof(T));
    std::memcpy(values.data(), text_.data() + place + sizeof bytes, bytes);
    return values;
  }

 private:
  std::string text_;
  size_t data_;
};

using Vector = std::array<double, 3>;
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector vector_at(const std::vector<float>& values, size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}

// Returns the force of every point on block a, N: tension acts along the normal, towards block b.
std::vector<Vector> forces_on_a(const Vtu& joints) {
  const auto area = joints.array<float>("area_m2"), normal = joints.array<float>("normal"),
             axis = joints.array<float>("shear_axis"), traction = joints.array<float>("traction_Pa");
  std::vector<Vector> forces;
  for (size_t i = 0; i < area.size(); ++i) {
    const Vector n = vector_at(normal, i), s = vector_at(axis, i), t = cross(n, s), stress = vector_at(traction, i);
    Vector force{};
    for (size_t k = 0; k < 3; ++k)
      force[k] = double{area[i]} * (stress[0] * n[k] + stress[1] * s[k] + stress[2] * t[k]);
    forces.push_back(force);
  }
  return forces;
}

// The axes of an inclined joint are in the file, too.
TEST_F(Outputs, ForcesOnABlockOnASlopeBalanceItsWeight) {
  const std::string scene = write("slope.toml", R"([solver]
damping = "local"
[materials.stone]
young_modulus = 10e9
poisson_ratio = 0.2
density = 2000.0
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e9
shear_stiffness = 0.5e9
friction_angle = 40.0
[[block]]
name = "slope"
material = "stone"
fixed = true
box = { lower = [-1, -0.2, -1], size = [2, 0.2, 2] }
rotation = [10, 20, 15]
[[block]]
name = "stone"
material = "stone"
box = { lower = [-0.2, 0, -0.2], size = [0.4, 0.1, 0.4] }
rotation = [10, 20, 15]
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
ramp_time = 0.1
duration = 0.5
[output]
frames = 1
frames_of = "last"
plots = false
)");
  ASSERT_EQ(quoin({"run", scene, "--out", out(), "--threads", "1"}), 0) << error_;
  const Vtu joints(out() + "/joints_0001.vtu");
  const auto a = joints.array<std::int32_t>("block_a"), b = joints.array<std::int32_t>("block_b");
  const std::vector<Vector> forces = forces_on_a(joints);
  ASSERT_GE(forces.size(), 4u);
  Vector sum{};
  for (size_t i = 0; i < forces.size(); ++i) {
    ASSERT_NE(a[i], b[i]);
    for (size_t k = 0; k < 3; ++k) sum[k] += (a[i] == 1 ? 1.0 : -1.0) * forces[i][k];
  }
  // Tolerance for vibration after 0.5 s, about a hundred periods with local damping (eq. 1).
  const double weight = 2000.0 * 9.81 * 0.4 * 0.1 * 0.4;
  EXPECT_NEAR(sum[0], 0.0, 1e-4 * weight);
  EXPECT_NEAR(sum[1], weight, 1e-4 * weight);
  EXPECT_NEAR(sum[2], 0.0, 1e-4 * weight);
}

// A wall at rest under its weight and a displacement of the top beam. The forces of a block's joints balance its
// weight, and their moment is 0.
TEST_F(Outputs, ForcesOnABlockFormedFromTheJointsFileBalanceItsWeight) {
  std::string text = read_all(small_);
  text = text.substr(0, text.find("[[stage]]")) + R"([[stage]]
name = "push"
kind = "custom"
gravity = [0, -9.81, 0]
duration = 0.01
ramp_time = 0.005
[[stage.control]]
body = "bottom_beam"
[[stage.control]]
body = "top_beam"
velocity = [1e-4, -1e-4, 0]
[[stage]]
name = "rest"
kind = "custom"
equilibrium_ratio = 1e-7
[[stage.control]]
body = "bottom_beam"
[[stage.control]]
body = "top_beam"
[output]
frames = 1
frames_of = "last"
plots = false
)";
  ASSERT_EQ(quoin({"run", write("weight.toml", text), "--out", out(), "--threads", "1"}), 0) << error_;
  const Vtu blocks(out() + "/blocks_0001.vtu"), joints(out() + "/joints_0001.vtu");

  const auto place = blocks.array<float>("position");
  const auto connectivity = blocks.array<std::int64_t>("connectivity"), offsets = blocks.array<std::int64_t>("offsets");
  const auto block = blocks.array<std::int32_t>("block");
  struct Load {
    double volume = 0.0;
    Vector first_moment{}, force{}, moment{};  // moment about the origin
  };
  std::map<int, Load> loads;
  for (size_t cell = 0; cell < block.size(); ++cell) {
    const std::int64_t first = cell > 0 ? offsets[cell - 1] : 0;
    if (offsets[cell] - first != 4) continue;  // a rigid beam
    std::array<Vector, 4> corner{};
    Vector centre{};
    for (size_t k = 0; k < 4; ++k) {
      for (size_t axis = 0; axis < 3; ++axis) {
        corner[k][axis] = place[3 * static_cast<size_t>(connectivity[static_cast<size_t>(first) + k]) + axis];
        centre[axis] += corner[k][axis] / 4;
      }
    }
    std::array<Vector, 3> edge{};
    for (size_t k = 0; k < 3; ++k) {
      for (size_t axis = 0; axis < 3; ++axis) edge[k][axis] = corner[k + 1][axis] - corner[0][axis];
    }
    const Vector normal = cross(edge[0], edge[1]);
    const double volume = std::abs(normal[0] * edge[2][0] + normal[1] * edge[2][1] + normal[2] * edge[2][2]) / 6;
    Load& load = loads[block[cell]];
    load.volume += volume;
    for (size_t axis = 0; axis < 3; ++axis) load.first_moment[axis] += volume * centre[axis];
  }
  ASSERT_EQ(loads.size(), 5u);

  const auto position = joints.array<float>("position");
  const auto a = joints.array<std::int32_t>("block_a"), b = joints.array<std::int32_t>("block_b");
  const std::vector<Vector> forces = forces_on_a(joints);
  ASSERT_EQ(a.size(), forces.size());
  double largest = 0.0;
  for (size_t i = 0; i < forces.size(); ++i) {
    const Vector& force = forces[i];
    const Vector moment = cross(vector_at(position, i), force);
    for (const auto& [which, sign] : {std::pair(a[i], 1.0), std::pair(b[i], -1.0)}) {
      const auto found = loads.find(which);
      if (found == loads.end()) continue;
      for (size_t axis = 0; axis < 3; ++axis) {
        found->second.force[axis] += sign * force[axis];
        found->second.moment[axis] += sign * moment[axis];
      }
    }
    largest = std::max(largest, std::hypot(force[0], force[1], force[2]));
  }
  // Tolerance for rounding to 24 bits of some tens of forces up to the largest (6e-8 each). It includes the unbalanced
  // force at rest, 1e-7 of the mean contact force at each of tens of gridpoints.
  const double tolerance = 1e-5 * largest;
  for (const auto& [which, load] : loads) {
    const double weight = 1900.0 * 9.81 * load.volume;
    const Vector centre_of_weight = cross(load.first_moment, {0.0, -1900.0 * 9.81, 0.0});
    EXPECT_GT(weight, 100 * tolerance) << "the test must see the weight";
    EXPECT_NEAR(load.force[0], 0.0, tolerance) << which;
    EXPECT_NEAR(load.force[1], weight, tolerance) << which;
    EXPECT_NEAR(load.force[2], 0.0, tolerance) << which;
    for (size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(load.moment[axis] + centre_of_weight[axis], 0.0, tolerance * 0.5) << which;  // arms below 0.5 m
  }
}

// Rows of numbers between blank lines, as gnuplot reads them. A word that is not a number ends a row.
using Rows = std::vector<std::vector<double>>;
std::vector<Rows> blocks_of(const std::string& text) {
  std::vector<Rows> blocks(1);
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream numbers(line);
    std::vector<double> row;
    for (double x; numbers >> x;) row.push_back(x);
    if (!row.empty())
      blocks.back().push_back(row);
    else if (!blocks.back().empty())
      blocks.emplace_back();
  }
  if (blocks.back().empty()) blocks.pop_back();
  return blocks;
}
std::string datablock(const std::string& script, const std::string& name) {
  const std::string mark = name + " << EOD\n";
  const size_t at = script.find(mark);
  return at == std::string::npos ? "" : script.substr(at + mark.size(), script.find("\nEOD", at) - at - mark.size());
}
std::array<double, 2> range_of(const std::string& script, const std::string& axis) {
  const std::string mark = "set " + axis + "range [";
  const size_t at = script.find(mark) + mark.size();
  return {std::stod(script.substr(at)), std::stod(script.substr(script.find(':', at) + 1))};
}
double signed_area(const Rows& polygon) {  // counter-clockwise positive
  double area = 0.0;
  for (size_t i = 0; i + 1 < polygon.size(); ++i)
    area += (polygon[i][0] * polygon[i + 1][1] - polygon[i + 1][0] * polygon[i][1]) / 2;
  return area;
}

// Pictures of the small wall: 2 courses of 62.5 mm, 440 mm long, between beams of 100 mm; the top moves by 0.5 mm.
TEST_F(Outputs, PicturesAreDrawnFromTheRun) {
  ASSERT_EQ(run_small({"--set", "output.frames=1"}), 0) << error_;
  const fs::path plots = fs::path(out()) / "plots";

  // The curve has mm, kN and MPa (on 440 x 100 mm) of the rows of the history from the end of the first stage on.
  const Rows curve = blocks_of(read_all(plots / "curve.dat"))[0];
  std::ifstream history(out() + "/history.csv");
  Rows rows;
  std::string line;
  std::getline(history, line);
  while (std::getline(history, line)) {
    const std::string numbers = line.substr(0, 2) + line.substr(line.find("\",") + 2);
    rows.emplace_back();
    std::istringstream fields(numbers);
    for (std::string field; std::getline(fields, field, ',');)
      rows.back().push_back(field.empty() ? NAN : std::stod(field));
  }
  // stage, step, time, displacement, vertical displacement, horizontal force, vertical force
  size_t shear = 0;
  while (rows[shear][0] < 2) ++shear;
  // Rows without displacement are omitted.
  const size_t still = rows.size() - shear + 1 - curve.size();
  ASSERT_LT(still, 20u);
  for (size_t i = 0; i < still; ++i) EXPECT_LE(std::abs(rows[shear + i][3]), 1e-9 * rows.back()[3]);
  double peak = 0.0;
  for (size_t i = 0; i < curve.size(); ++i) {
    const auto& row = rows[i == 0 ? shear - 1 : shear - 1 + still + i];
    EXPECT_NEAR(curve[i][0], 1e3 * row[3], 1e-6 * std::abs(1e3 * row[3]));
    EXPECT_NEAR(curve[i][1], 1e-3 * row[5], 1e-6 * std::abs(1e-3 * row[5]));
    EXPECT_NEAR(curve[i][2], row[6] / (0.44 * 0.1) / 1e6, 1e-6 * row[6] / 0.044 / 1e6);
    peak = std::max(peak, row[5]);
  }
  EXPECT_EQ(summary()["peak_horizontal_force_N"].get<double>(), peak);
  const std::string curve_script = read_all(plots / "curve.gp");
  EXPECT_THAT(curve_script, HasSubstr("displacement of the top beam (mm)"));
  EXPECT_NEAR(range_of(curve_script, "x")[1], 1.02 * curve.back()[0], 1e-3);
  EXPECT_EQ(range_of(curve_script, "x")[0], 0.0);
  EXPECT_NEAR(blocks_of(datablock(curve_script, "$peak"))[0][0][1], peak / 1e3, 1e-5 * peak / 1e3);

  // The wall: bricks at the positions of the frame file, with displacements scaled by 20. That is the largest of 1, 2,
  // 5, 10, ... with which half a millimetre is below 7.5 % of 325 mm.
  const std::string script = read_all(plots / "cracks.gp");
  EXPECT_THAT(script, HasSubstr("drawn 20 times larger"));
  EXPECT_THAT(script, HasSubstr(fmt::format("top beam moved {:.2f} mm, horizontal force {:.1f} kN, law fracture_energy",
                                            curve.back()[0], curve.back()[1])));
  const Vtu blocks(out() + "/blocks_0001.vtu");
  const auto place = blocks.array<float>("position"), moved = blocks.array<float>("displacement_m");
  ASSERT_EQ(place.size(), moved.size());
  double largest = 0.0;
  std::set<std::pair<long, long>> front;  // positions of all gridpoints at z = 0.1 m, in hundredths of a millimetre
  for (size_t i = 0; i < place.size(); i += 3) {
    largest = std::max<double>(largest, std::hypot(moved[i], moved[i + 1]));
    if (place[i + 2] < 0.0999F) continue;
    const double x = 1e5 * (place[i] + 20.0 * moved[i]), y = 1e5 * (place[i + 1] + 20.0 * moved[i + 1]);
    for (const int dx : {-1, 0, 1})
      for (const int dy : {-1, 0, 1}) front.emplace(std::lround(x) + dx, std::lround(y) + dy);
  }
  const auto bricks = blocks_of(read_all(plots / "bricks.dat")), beams = blocks_of(read_all(plots / "beams.dat"));
  ASSERT_EQ(bricks.size(), 5u);
  ASSERT_EQ(beams.size(), 2u);
  const auto [x_low, x_high] = range_of(script, "x");
  const auto [y_low, y_high] = range_of(script, "y");
  double area = 0.0;
  for (const auto* list : {&bricks, &beams})
    for (const Rows& outline : *list) {
      EXPECT_EQ(outline.front(), outline.back());
      area += signed_area(outline);
      for (const auto& p : outline) {
        EXPECT_TRUE(front.contains({std::lround(100 * p[0]), std::lround(100 * p[1])})) << p[0] << ' ' << p[1];
        EXPECT_TRUE(p[0] > x_low && p[0] < x_high && p[1] > y_low && p[1] < y_high) << p[0] << ' ' << p[1];
      }
    }
  EXPECT_NEAR(area, 440.0 * 325.0, 0.01 * 440.0 * 325.0);  // 20 times a strain of 5e-4
  for (const Rows& outline : bricks) {
    const bool half = signed_area(outline) < 1.5 * 110 * 62.5;
    EXPECT_EQ(outline.size(), half ? 7u : 11u) << "2 hexahedra along a half, 1 up";
  }
  // Margins: 3 % of the length plus the horizontal displacement at the sides, and 0.3 of the displacement above.
  const double sway = 20e3 * largest, margin = 0.03 * 440.0;
  EXPECT_NEAR(x_low, -margin - sway, 0.01);
  EXPECT_NEAR(x_high, 440.0 + margin + sway, 0.01);
  EXPECT_NEAR(y_low, -100.0 - margin, 0.01);
  EXPECT_NEAR(y_high, 225.0 + margin + 0.3 * sway, 0.01);

  // Joints are quads between their two sides; their total length is that of three bed joints and three head joints.
  double length = 0.0, left = 0.0, right = 0.0;
  for (const int kind : {0, 1, 2, 3, 4, 5})
    for (const Rows& quad : blocks_of(read_all(plots / fmt::format("joints_{}.dat", kind)))) {
      ASSERT_EQ(quad.size(), 5u);
      EXPECT_EQ(quad.front(), quad.back());
      length += std::hypot(quad[1][0] - quad[0][0], quad[1][1] - quad[0][1]);
      for (const auto& p : quad) left = std::min(left, p[0]), right = std::max(right, p[0]);
    }
  EXPECT_NEAR(left, 0.0, sway + 0.5) << "from end to end of the wall";
  EXPECT_NEAR(right, 440.0, sway + 0.5);
  EXPECT_NEAR(length, 3 * 440.0 + 3 * 62.5, 0.01 * 1500.0);
}

// Cells of a frame: tetrahedra fill the volume of the bricks, hexahedra that of the beams, quads the area of joints.
TEST_F(Outputs, CellsOfAFrameFillTheWall) {
  ASSERT_EQ(run_small({"--set", "output.frames=1", "--set", "output.plots=false"}), 0) << error_;
  const fs::path file = out() + "/blocks_0001.vtu", joints_file = out() + "/joints_0001.vtu";
  const Vtu blocks(file), joints(joints_file);
  const auto count = [](const fs::path& of, const std::string& what) {
    const std::string text = read_all(of), mark = what + "=\"";
    return std::stoul(text.substr(text.find(mark) + mark.size(), 20));
  };
  // Arrays have the number of components of their kind.
  for (const auto& [of, name, components] : {std::tuple{file, "block", 1},
                                             {file, "types", 1},
                                             {file, "connectivity", 1},
                                             {file, "position", 3},
                                             {file, "displacement_m", 3},
                                             {file, "stress_Pa", 6},
                                             {joints_file, "area_m2", 1},
                                             {joints_file, "normal", 3},
                                             {joints_file, "slip_m", 1}}) {
    const std::string text = read_all(of), mark = "NumberOfComponents=\"";
    const size_t at = text.find(std::string("Name=\"") + name + "\"");
    EXPECT_EQ(std::stoi(text.substr(text.find(mark, at) + mark.size(), 3)), components) << name;
  }
  const auto place = blocks.array<float>("position");
  const auto cell = blocks.array<std::int64_t>("connectivity"), end = blocks.array<std::int64_t>("offsets");
  const auto type = blocks.array<std::uint8_t>("types");
  EXPECT_EQ(count(file, "NumberOfPoints"), place.size() / 3);
  EXPECT_EQ(count(file, "NumberOfCells"), type.size());
  EXPECT_EQ(blocks.array<float>("stress_Pa").size(), 6 * type.size());
  EXPECT_EQ(blocks.array<std::int32_t>("block").size(), type.size());
  EXPECT_EQ(blocks.array<std::int32_t>("unit").size(), type.size());
  EXPECT_EQ(blocks.array<std::int32_t>("course").size(), type.size());
  ASSERT_EQ(end.size(), type.size());
  ASSERT_EQ(static_cast<size_t>(end.back()), cell.size());
  const auto edge = [](const std::vector<float>& at, std::int64_t from, std::int64_t to) {
    const Vector a = vector_at(at, static_cast<size_t>(from)), b = vector_at(at, static_cast<size_t>(to));
    return Vector{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  };
  const auto dot = [](const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  double bricks = 0.0, beams = 0.0;
  for (size_t i = 0; i < type.size(); ++i) {
    const auto* p = &cell[i > 0 ? static_cast<size_t>(end[i - 1]) : 0];
    const auto size = end[i] - (i > 0 ? end[i - 1] : 0);
    const double box = dot(cross(edge(place, p[0], p[1]), edge(place, p[0], size == 8 ? p[3] : p[2])),
                           edge(place, p[0], size == 8 ? p[4] : p[3]));
    EXPECT_GT(box, 0.0) << "VTK's order of corners is right-handed";
    EXPECT_EQ(type[i], size == 8 ? 12 : 10);
    (size == 8 ? beams : bricks) += size == 8 ? box : box / 6;
  }
  EXPECT_NEAR(bricks, 0.44 * 0.125 * 0.1, 1e-6 * 0.0055);  // rounding to 24 bits
  EXPECT_NEAR(beams, 2 * 0.44 * 0.1 * 0.1, 1e-6 * 0.0088);

  const auto at = joints.array<float>("position");
  const auto quad = joints.array<std::int64_t>("connectivity"), last = joints.array<std::int64_t>("offsets");
  EXPECT_EQ(count(joints_file, "NumberOfPoints"), at.size() / 3);
  EXPECT_EQ(count(joints_file, "NumberOfCells"), last.size());
  EXPECT_EQ(joints.array<std::uint8_t>("types"), std::vector<std::uint8_t>(last.size(), 9));
  double surface = 0.0, by_points = 0.0;
  for (size_t i = 0; i < last.size(); ++i) {
    ASSERT_EQ(last[i], static_cast<std::int64_t>(4 * i + 4));
    const auto* p = &quad[4 * i];
    const Vector a = cross(edge(at, p[0], p[1]), edge(at, p[0], p[3])),
                 b = cross(edge(at, p[2], p[3]), edge(at, p[2], p[1]));
    EXPECT_GT(dot(a, b), 0.0) << "no quad crosses itself";
    surface += (std::sqrt(dot(a, a)) + std::sqrt(dot(b, b))) / 2;
  }
  for (const float area : joints.array<float>("area_m2")) by_points += area;
  const double joint_area = 3 * 0.44 * 0.1 + 3 * 0.0625 * 0.1;
  EXPECT_NEAR(surface, joint_area, 1e-5 * joint_area);
  EXPECT_NEAR(by_points, joint_area, 1e-5 * joint_area);
  for (const char* name : {"opening_m", "slip_m", "damage_tension", "damage_shear", "plastic_closure_m"})
    EXPECT_EQ(joints.array<float>(name).size(), at.size() / 3) << name;
}

// Returns the corners of every polygon of a script, with the number after "cb" as third number, or 0. Polygons are in
// the order of their numbers, in which gnuplot draws them.
std::vector<Rows> polygons_of(const std::string& script) {
  std::map<int, Rows> polygons;
  std::istringstream lines(script);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("set object ", 0) != 0) continue;
    const size_t cb = line.find(" cb ");
    const double value = cb == std::string::npos ? 0.0 : std::stod(line.substr(cb + 4));
    Rows& corners = polygons[std::stoi(line.substr(std::string("set object ").size()))];
    for (size_t at = line.find("from "); at != std::string::npos; at = line.find(" to ", at + 1)) {
      const size_t begin = line.find(' ', at + 1) + 1, comma = line.find(',', begin);
      corners.push_back({std::stod(line.substr(begin)), std::stod(line.substr(comma + 1)), value});
    }
  }
  std::vector<Rows> in_order;
  for (const auto& [number, corners] : polygons) in_order.push_back(corners);
  return in_order;
}

// Two blocks beside each other on a longer one, all in one plane: the pictures have their fronts and the three joints.
TEST_F(Outputs, PicturesOfBlocksInAPlaneShowTheirFronts) {
  ASSERT_EQ(quoin({"run", block_scene(), "--out", out()}), 0) << error_;
  const std::string mechanism = read_all(out() + "/plots/mechanism.gp"), cracks = read_all(out() + "/plots/cracks.gp");
  // Lower and upper corners; the base of 1 x 0.2 m extends beyond the picture.
  const Rows fronts[] = {{{0, -0.08}, {0.88, 0}}, {{0, 0}, {0.4, 0.2}}, {{0.4, 0}, {0.8, 0.2}}};
  for (const std::string* script : {&mechanism, &cracks}) {
    const auto faces = polygons_of(*script);
    ASSERT_EQ(faces.size(), 3u);
    for (size_t f = 0; f < 3; ++f) {
      ASSERT_EQ(faces[f].size(), 5u);
      for (size_t k = 0; k < 2; ++k) {
        const double low = fronts[f][0][k], high = fronts[f][1][k];
        int at_low = 0, at_high = 0;  // numbers of the four corners, which fall for a millisecond
        for (size_t i = 0; i < 4; ++i) {
          at_low += std::abs(faces[f][i][k] - low) < 1e-5;
          at_high += std::abs(faces[f][i][k] - high) < 1e-5;
        }
        EXPECT_EQ(at_low, 2);
        EXPECT_EQ(at_high, 2);
        EXPECT_EQ(faces[f][0][k], faces[f][4][k]);
      }
      if (script == &cracks) continue;
      EXPECT_EQ(faces[f][0][2] > 0, f > 0) << "the base is fixed";
      double fallen = 1.0;
      for (const auto& corner : faces[1]) fallen = std::min(fallen, corner[1]);
      EXPECT_NEAR(faces[f][0][2], f > 0 ? -1e3 * fallen : 0.0, 1e-9) << "mm";
    }
    // The margin on each side is a tenth of the length of the free blocks.
    EXPECT_NEAR(range_of(*script, "x")[0], -0.08, 1e-5);
    EXPECT_NEAR(range_of(*script, "x")[1], 0.88, 1e-5);
    EXPECT_NEAR(range_of(*script, "y")[0], -0.08, 1e-5);
    EXPECT_NEAR(range_of(*script, "y")[1], 0.28, 1e-5);
  }
  const auto lines = blocks_of(datablock(cracks, "$crack0"));
  ASSERT_EQ(lines.size(), 3u);
  double along_x = 0.0, along_y = 0.0;
  for (const Rows& line : lines) {
    ASSERT_EQ(line.size(), 2u);
    along_x += std::abs(line[1][0] - line[0][0]), along_y += std::abs(line[1][1] - line[0][1]);
  }
  EXPECT_NEAR(along_x, 0.8, 1e-5);
  EXPECT_NEAR(along_y, 0.2, 1e-5);
  const auto cbrange = range_of(mechanism, "cb");
  EXPECT_NEAR(cbrange[1], polygons_of(mechanism)[1][0][2], 1e-9) << "up to the largest displacement";
}

}  // namespace
