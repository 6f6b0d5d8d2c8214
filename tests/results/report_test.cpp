// The page of a run: its contents, and messages for damaged results.
#include "results/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "../dry_stone.h"
#include "base/error.h"
#include "files/file.h"
#include "files/gnuplot.h"
#include "folder.h"
#include "results/colours.h"
#include "results/history.h"
#include "results/plots.h"
#include "results/summary.h"
#include "results/vtk.h"
#include "scene/read_scene.h"

namespace quoin {
namespace {

namespace fs = std::filesystem;

// Two rigid stones in large motion, of which one slides on the other.
const std::string kStones =
    "[materials.stone]\nyoung_modulus = 1e10\npoisson_ratio = 0.2\ndensity = 2000\n[joints.dry]\nlaw = "
    "\"coulomb_slip\"\n"
    "initial_state = \"dry\"\nnormal_stiffness = 1e9\nshear_stiffness = 5e8\nfriction_angle = 30\n"
    "[[block]]\nname = \"base\"\nfixed = true\nmaterial = \"stone\"\nbox = { lower = [0, 0, 0], size = [1, 0.2, 0.5] "
    "}\n"
    "[[block]]\nname = \"stone\"\nmaterial = \"stone\"\nbox = { lower = [0.2, 0.2, 0.1], size = [0.3, 0.2, 0.3] }\n"
    "[solver]\nlarge_motion = \"always\"\n[output]\nmonitor = \"stone\"\nframes = 1\n"
    "[[stage]]\ngravity = [0, -9.81, 0]\nduration = 0.002\n";

// Returns a half unit between two beams on the lattice; the upper beam moves up.
std::string pulled_wall(const std::string& stage) {
  return "[materials.brick]\nyoung_modulus = 16.7e9\npoisson_ratio = 0.15\ndensity = 1900.0\n"
         "[joints.mortar]\nlaw = \"fracture_energy\"\nnormal_stiffness = 82e9\nshear_stiffness = 36e9\n"
         "tensile_strength = 0.2e6\ncohesion = 0.3e6\nfriction_angle = 35\nfracture_energy_tension = 15\n"
         "fracture_energy_shear = 125\n[wall]\ncourses = 1\nunits_per_course = 1\nunit = [0.22, 0.0625, 0.1]\n"
         "zones = [1, 1, 1]\nmid_unit_joints = false\nunit_material = \"brick\"\nbed_joint = \"mortar\"\n"
         "head_joint = \"mortar\"\nbeam_joint = \"mortar\"\n[output]\nframes = 1\n"
         "[[stage]]\nname = \"pull\"\nkind = \"custom\"\nramp_time = 0.001\n" +
         stage +
         "[[stage.control]]\nbody = \"bottom_beam\"\nvelocity = [0, 0, 0]\n[[stage.control]]\nbody = \"top_beam\"\n"
         "velocity = [0, 0.02, 0]\n";
}
const char* const kMeasuredUpright = "direction = \"y\"\ndisplacement = 5e-5\n";
const char* const kDrivenUpright = "duration = 0.003\n";

class Report : public InFolder {
 protected:
  void SetUp() override {
    InFolder::SetUp();
    fs::create_directories(folder_ / "three/examples/js/controls");
    for (const char* name : {"three/three.min.js", "three/examples/js/controls/OrbitControls.js"})
      write_file(folder_ / name, "//\n");
    setenv("QUOIN_THREE_JS", (folder_ / "three").c_str(), 1);
  }

  // Runs a scene and writes the files of a page.
  struct Recorder : Observer {
    History history;
    VtkSeries frames;
    Recorder(const fs::path& folder, const Simulation& simulation, const Surfaces& surfaces, bool compressed)
        : history(folder / "history.csv", simulation), frames(folder, surfaces, {}, compressed) {}
    void on_row(const HistoryRow& row) override { history.add(row); }
    void on_frame(const Simulation& simulation, int, int) override { frames.add_frame(simulation); }
  };
  void write_run(const std::string& scene, bool compressed = false) {
    Simulation simulation(read_scene_text(scene, "page.toml", {}), 1);
    const Surfaces surfaces;
    Recorder recorder(folder_, simulation, surfaces, compressed);
    simulation.run(recorder);
    recorder.history.finish();
    recorder.frames.finish();
    write_summary(folder_ / "summary.json", simulation, recorder.history.rows(), {});
    rows_ = recorder.history.rows();
  }

  // Returns the page or the message of a refusal; other exceptions fail the test.
  std::string outcome() {
    try {
      return read_all(write_report({folder_}));
    } catch (const Error& error) {
      EXPECT_EQ(error.exit_code, Exit::bad_input) << error.what();
      return error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
      return error.what();
    }
  }

  // Changes one byte in seven, for speed, and truncates the file at some positions. Returns the number of refusals.
  static constexpr std::size_t kStride = 7;
  long damage(const std::string& file) {
    const fs::path path = folder_ / file;
    const std::string whole = read_all(path);
    long refused = 0;
    const auto look = [&](const std::string& bytes, std::size_t at) {
      std::ofstream(path, std::ios::binary) << bytes;
      refused += outcome().find("<!DOCTYPE") == std::string::npos;
      EXPECT_FALSE(HasFailure()) << file << ", byte " << at;
    };
    for (std::size_t i = 0; i < whole.size() && !HasFailure(); i += kStride) {
      std::string bytes = whole;
      bytes[i] = static_cast<char>(bytes[i] ^ (i / kStride % 2 ? 0x80 : 0x15));
      look(bytes, i);
    }
    for (std::size_t size = 0; size < whole.size() && !HasFailure(); size += 1 + whole.size() / 50)
      look(whole.substr(0, size), size);
    std::ofstream(path, std::ios::binary) << whole;
    EXPECT_NE(outcome().find("<!DOCTYPE"), std::string::npos) << file;
    return refused;
  }

  std::vector<HistoryRow> rows_;
};

// Damaged files are refused or drawn: numbers of points, cells and blocks are checked.
TEST_F(Report, RefusesDamagedFramesOrDrawsThem) {
  write_run(kStones);
  for (const char* file : {"blocks_0001.vtu", "joints_0001.vtu"}) EXPECT_GT(damage(file), 20) << file;
}

TEST_F(Report, RefusesDamagedCompressedFramesOrDrawsThem) {
  write_run(pulled_wall(kDrivenUpright), true);
  for (const char* file : {"blocks_0000.vtu", "joints_0001.vtu"}) EXPECT_GT(damage(file), 20) << file;
}

TEST_F(Report, RefusesDamagedTablesOrShowsThem) {
  write_run(kStones);
  for (const char* file : {"history.csv", "summary.json", "blocks.pvd"}) EXPECT_GT(damage(file), 2) << file;
  write_file(folder_ / "summary.json", std::string(100000, '['));
  EXPECT_NE(outcome().find("summary.json"), std::string::npos);
}

nlohmann::json head_of(const std::string& page) {
  const std::string begin = "class=\"head\">";
  const std::size_t from = page.find(begin) + begin.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

// Blocks of 19.62 and 9.81 kN on a fixed one, friction 35 degrees, pushed in turn along x; each stage watches its own.
const std::string kPushedInTurn = dry_stone(35.0) + R"([[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1.0, -0.2, 0.0], size = [5.0, 0.2, 1.0] }
[[block]]
name = "left"
material = "stone"
box = { lower = [0.0, 0.0, 0.0], size = [1.0, 1.0, 1.0] }
[[block]]
name = "right_one"
material = "stone"
box = { lower = [2.0, 0.0, 0.0], size = [1.0, 0.5, 1.0] }
[[stage]]
name = "weight"
gravity = [0.0, -9.81, 0.0]
ramp_time = 0.05
duration = 0.1
[[stage]]
name = "push_left"
monitor = "left"
displacement = 0.002
ramp_time = 0.02
[[stage.velocity]]
block = "left"
velocity = [0.02, "free", "free"]
[[stage]]
name = "push_right"
monitor = "right_one"
displacement = 0.001
ramp_time = 0.02
[[stage.velocity]]
block = "right_one"
velocity = [0.02, "free", "free"]
[output]
monitor = "left"
frames = 0
)";

// Tables of numbers after a line of names.
std::vector<std::vector<double>> numbers_of(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::vector<std::vector<double>> rows;
  while (std::getline(stream, line)) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; cells >> cell;) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

// Curve, histories and peak are those of the block that the last stage watches: it slides at mu W = 6.869 kN, the other
// at 13.74 kN.
TEST_F(Report, CurvesHaveTheRowsOfOneBlock) {
  write_run(kPushedInTurn);
  const Scene scene = read_scene_text(kPushedInTurn, "page.toml", {});
  const double carried = 9.81e3 * std::tan(35.0 * std::numbers::pi / 180.0);  // N
  EXPECT_NEAR(find_peak(rows_, scene).force, carried, 1e-3 * carried);

  plot_curve(folder_, rows_, scene, "law", "");
  const auto curve = numbers_of(folder_ / "plots/curve.dat");
  ASSERT_GT(curve.size(), 20u);
  for (std::size_t i = 0; i < curve.size(); ++i) {
    EXPECT_LT(curve[i][1], 1.001e-3 * carried) << i;
    // One way: no line back from the other block.
    EXPECT_GE(curve[i][0], i > 0 ? curve[i - 1][0] : 0.0) << i;
  }
  EXPECT_NE(read_all(folder_ / "plots/curve.gp").find("of the right one"), std::string::npos);

  plot_histories(folder_, rows_, scene, "");
  EXPECT_NE(read_all(folder_ / "plots/histories.gp").find("motion of right one"), std::string::npos);
  const auto histories = numbers_of(folder_ / "plots/histories.dat");  // time, then the displacement along x
  ASSERT_EQ(histories.size(), rows_.size());
  for (std::size_t i = 0; i < rows_.size(); ++i)
    EXPECT_EQ(std::isnan(histories[i][1]), rows_[i].stage < 2) << "row " << i;
}

// A cube on springs of kn A = 1 GN/m is pressed by 0.1 mm beyond its settlement W/(kn A), and then released. Tolerance
// 5 %, as the end of the stage is found some steps late.
TEST_F(Report, AVerticalTestKeepsItsPeakWhereARestFollows) {
  write_run(dry_stone(35.0) + kCubeOnGround + kPressedCube + R"([[stage]]
duration = 0.02
[output]
monitor = "cube"
frames = 0
)");
  const nlohmann::json summary = nlohmann::json::parse(read_all(folder_ / "summary.json"));
  const double weight = 2000 * 9.81, stiffness = 1e9, force = weight + 1e-4 * stiffness;
  EXPECT_TRUE(summary.at("peak_horizontal_force_N").is_null());
  ASSERT_TRUE(summary.at("peak_vertical_force_N").is_number());
  const double peak = summary.at("peak_vertical_force_N");
  EXPECT_NEAR(peak, force, 0.05 * force);
  EXPECT_NEAR(summary.at("displacement_at_peak_m"), peak / stiffness, 1e-3 * peak / stiffness);
}

// A stage of a building with a monitor of its own shows that body, on a curve of its own.
TEST(Curve, OfABuildingHasTheStagesThatWatchTheSame) {
  const Scene scene = read_scene_text(read_all(QUOIN_TESTS "/host/small_building.toml") + R"([[stage]]
name = "beam"
kind = "custom"
monitor = "floor_1_1"
duration = 0.01
[[stage.control]]
body = "floor_1_1"
velocity = [0.01, "free", "free"]
)",
                                      "beam.toml", {});
  ASSERT_EQ(scene.stages.size(), 3u);
  EXPECT_EQ(moved_part(scene, scene.stages[0]), "roof");
  EXPECT_EQ(moved_part(scene, scene.stages[1]), "roof");
  EXPECT_EQ(moved_part(scene, scene.stages[2]), "floor 1 1");
  std::vector<HistoryRow> rows(2);
  rows[0].stage = 1, rows[0].joint_force = {200, 0, 0};
  rows[1].stage = 2, rows[1].joint_force = {-100, 0, 0};
  EXPECT_EQ(find_peak(rows, scene).row, 1);
  EXPECT_EQ(find_peak(rows, scene).force, 100);
}

// A toy wall in closed form. Its envelope rises to 100 N at 0.5 mm, and falls by 40 N/mm: it has 80 N at 1 mm. Below
// the farthest displacement so far to a side, the force is on the line to the origin. A half cycle to an amplitude that
// has been reached has 70 % of the force.
struct ToyWall {
  double side = 1.0;  // along which it is pushed first
  std::array<double, 2> farthest{};
  std::vector<HistoryRow> rows;
  void move_to(int stage, double time, double u, bool again = false) {
    const std::size_t s = u < 0.0 ? 1 : 0;
    farthest[s] = std::max(farthest[s], std::abs(u));
    const double x = 1e3 * farthest[s], envelope = x < 0.5 ? 200.0 * x : 100.0 - 40.0 * (x - 0.5);
    HistoryRow& row = rows.emplace_back();
    row.stage = stage, row.time = time;
    row.monitor_displacement = {side * u, 0, 0};
    row.joint_force = {x > 0.0 ? -side * envelope * u / farthest[s] * (again ? 0.7 : 1.0) : 0.0, 0, 0};
  }
};
Scene wall_with(const std::string& stages) {
  std::string text = read_all(QUOIN_TESTS "/cli/small_wall.toml");
  const std::size_t at = text.find("[[stage]]\nname = \"shear\""), end = text.find("[output]");
  return read_scene_text(text.replace(at, end - at, stages), "wall.toml", {});
}
constexpr double kRow = 5e-6;  // m, largest distance of two rows

// Loss of strength counts on the envelope: unloading and repeated amplitudes had counted. Tolerance: two rows.
TEST(Loss, InCyclesIsThatOfTheirEnvelope) {
  for (const double side : {1.0, -1.0}) {
    for (const bool beyond : {false, true}) {
      const Scene scene = wall_with(
          fmt::format("[[stage]]\nname = \"shear\"\nkind = \"cycles\"\nvelocity = {}\namplitudes = [0.4e-3, 0.8e-3{}]\n"
                      "cycles = 2\n",
                      0.01 * side, beyond ? ", 1.6e-3" : ""));
      const Stage& stage = scene.stages.at(1);
      const CyclicMotion motion(*stage.cycles);
      ToyWall wall;
      wall.side = side;
      for (double t = 0.0; t < motion.duration(); t += kRow / 0.01)
        wall.move_to(1, 7.0 + t, side * motion.position(t), motion.half_cycle(t) % 4 > 1);
      const Peak peak = find_peak(wall.rows, scene);
      EXPECT_NEAR(peak.force, 100.0, 0.5);
      const auto lost = displacement_at_loss(wall.rows, scene, peak, 0.8);
      EXPECT_EQ(lost.has_value(), beyond) << side;
      EXPECT_NEAR(lost.value_or(1e-3), 1e-3, 2 * kRow) << side;
    }
  }
}

// Pushed to 0.8 mm, back to `back` and on to 1.2 mm: the loss is at 1 mm of the last stage, or on no side.
TEST(Loss, IsNoneWhileTheWallIsPushedBack) {
  std::string stages;
  for (const char* name : {"out", "back", "on"})
    stages += fmt::format("[[stage]]\nname = \"{}\"\nkind = \"shear\"\nvelocity = 0.01\ndisplacement = 0.001\n", name);
  const Scene scene = wall_with(stages);
  for (const double back : {0.0, -0.6e-3}) {
    ToyWall wall;
    for (double u = 0.0; u < 0.8e-3; u += kRow) wall.move_to(1, 0.0, u);
    for (double u = 0.8e-3; u > back; u -= kRow) wall.move_to(2, 1.0, u);
    EXPECT_FALSE(displacement_at_loss(wall.rows, scene, find_peak(wall.rows, scene), 0.8)) << back;
    for (double u = back; u < 1.2e-3; u += kRow) wall.move_to(3, 2.0, u);
    const auto lost = displacement_at_loss(wall.rows, scene, find_peak(wall.rows, scene), 0.8);
    ASSERT_TRUE(lost) << back;
    EXPECT_NEAR(*lost, 1e-3, 2 * kRow) << back;
  }
}

// Without a monitor rows have no displacement and no force, and the summary has no peak; nothing stands for them as 0.
TEST_F(Report, WithoutAMonitorNothingIsReportedAsMeasured) {
  std::string text = kStones;
  text.replace(text.find("monitor = \"stone\"\n"), 18, "");
  write_run(text);
  const nlohmann::json head = head_of(outcome()), &history = head.at("history"), &summary = head.at("summary");
  for (const char* column : {"displacement_m", "vertical_displacement_m", "horizontal_force_N", "vertical_force_N",
                             "monitor_dx_m", "monitor_fy_N"})
    for (const auto& value : history.at(column)) EXPECT_TRUE(value.is_null()) << column;
  EXPECT_GT(history.at("largest_displacement_m").back().get<double>(), 0.0);
  for (const char* key : {"peak_horizontal_force_N", "peak_vertical_force_N", "displacement_at_peak_m", "peak_of"})
    EXPECT_TRUE(summary.at(key).is_null()) << key;
  EXPECT_TRUE(summary.at("settings").at("stages")[0].at("curve").at("of").is_null());

  const Scene scene = read_scene_text(text, "page.toml", {});
  plot_curve(folder_, rows_, scene, "law", "");
  EXPECT_NE(read_all(folder_ / "plots/curve.gp").find("largest displacement of a block"), std::string::npos);
}

// A block of 2 t that does not slide (mu g = 6.87 m/s2) under ground accelerations of at most 3 m/s2.
std::string shaken_block(const std::string& motion) {
  return kPushedInTurn.substr(0, kPushedInTurn.find("[[block]]\nname = \"right_one\"")) +
         "[[stage]]\ngravity = [0, -9.81, 0]\nramp_time = 0.05\nduration = 0.1\n"
         "[[stage]]\nduration = 0.4\nground_motion = { " +
         motion +
         ", time = [0, 0.1, 0.2, 0.3, 0.4], acceleration = [0, 3, 0, -3, 0] }\n"
         "[output]\nmonitor = \"left\"\nframes = 1\n";
}

struct Shake {
  std::string motion, axis;
  double base_force;  // N
};
class ShakenReport : public Report, public ::testing::WithParamInterface<Shake> {};

// The response is along the motion: the base carries m a there, and the weight too where that is vertical.
TEST_P(ShakenReport, HasTheResponseAlongTheMotion) {
  const auto& [motion, axis, base_force] = GetParam();
  write_run(shaken_block(motion));
  const nlohmann::json summary = head_of(outcome()).at("summary"), &response = summary.at("response");
  EXPECT_EQ(response.at("axis"), axis);
  EXPECT_NEAR(response.at("base_force_N").get<double>(), base_force, 0.02 * base_force);
  const nlohmann::json& curve = summary.at("settings").at("stages")[1].at("curve");  // the page draws along it
  EXPECT_EQ(curve.at("along"), axis);
  const Vec3 along = curve.at("direction").get<Vec3>();
  double moved = 0.0;
  for (const HistoryRow& row : rows_)
    if (row.stage == 1) moved = std::max(moved, std::abs(dot(row.monitor_relative, along)));
  EXPECT_DOUBLE_EQ(response.at("displacement_m").get<double>(), moved);

  plot_curve(folder_, rows_, read_scene_text(shaken_block(motion), "page.toml", {}), "law", "");
  EXPECT_NE(read_all(folder_ / "plots/curve.gp").find(gnuplot_text("displacement along " + axis + " (mm)")),
            std::string::npos);
  double drawn = 0.0;
  for (const auto& point : numbers_of(folder_ / "plots/curve.dat")) drawn = std::max(drawn, std::abs(point[1]));
  EXPECT_NEAR(drawn, 1e3 * moved, 1e-5 * drawn);
}
INSTANTIATE_TEST_SUITE_P(Ways, ShakenReport,
                         ::testing::Values(Shake{"direction = [-2, 0, 0]", "x", 2e3 * 3.0},
                                           Shake{"direction = [0, 1, 0]", "y", 2e3 * (9.81 + 3.0)},
                                           Shake{"direction = [3, 0, 4]", "(0.6, 0, 0.8)", 2e3 * 3.0}));

// Of two components the stronger one, and a horizontal one before a vertical one.
TEST(ResponseAxis, IsThatOfTheStrongestHorizontalMotion) {
  const auto moved_by = [](const Vec3& direction, double largest) {
    GroundMotion::Component component;
    component.direction = direction;
    component.acceleration.time = {0.0, 1.0}, component.acceleration.value = {0.0, largest};
    return component;
  };
  Stage stage;
  stage.ground.emplace();
  stage.ground->components = {moved_by({1, 0, 0}, 1.0), moved_by({0, 0, 2}, -9.0), moved_by({0, 1, 0}, 20.0)};
  EXPECT_EQ(response_axis(stage).name, "z");
  stage.gravity = {0, 0, -9.81};
  EXPECT_EQ(response_axis(stage).name, "y") << "z is vertical";
  stage.gravity = {0, -9.81, 0};
  stage.ground->components.erase(stage.ground->components.begin() + 1);
  EXPECT_EQ(response_axis(stage).name, "x");
  // A force along an axis with a vertical part would have the weight: 7639 N of base shear were 1917 N.
  stage.ground->components = {moved_by({4, 2, 3}, 1.0)};
  EXPECT_EQ(response_axis(stage).name, "(0.8, 0, 0.6)");
  stage.ground->components = {moved_by({0, -2, 0}, 1.0)};
  EXPECT_EQ(response_axis(stage).name, "y");
}

// The page has the colours of cracks.png: blue for sliding and warm colours for opening.
TEST_F(Report, HasTheColoursOfThePictures) {
  write_run(kStones);
  const std::string page = outcome();
  const nlohmann::json styles = head_of(page).at("colours").at("cracks");
  ASSERT_EQ(styles.size(), kCrackStyles.size());
  for (const CrackStyle& style : kCrackStyles) {
    const nlohmann::json& shown = styles[static_cast<std::size_t>(style.crack)];
    EXPECT_EQ(shown.at("label"), style.label);
    EXPECT_EQ(shown.at("colour"), style.colour);
  }
  EXPECT_EQ(page.find("'sliding begun'"), std::string::npos) << "a second table";
}

// For a beam that moves up the curve and the reported displacement are vertical.
class UprightReport : public Report, public ::testing::WithParamInterface<const char*> {};

TEST_P(UprightReport, ShowsTheWayThatTheBeamIsDriven) {
  write_run(pulled_wall(GetParam()));
  const Scene scene = read_scene_text(pulled_wall(GetParam()), "page.toml", {});
  double largest = 0.0, there = 0.0;  // N, m
  for (const HistoryRow& row : rows_) {
    if (std::abs(row.joint_force[1]) > largest)
      largest = std::abs(row.joint_force[1]), there = row.monitor_displacement[1];
  }
  // 0.2 MPa over 0.22 m x 0.1 m is the largest force of the beams.
  ASSERT_NEAR(largest, 4.4e3, 0.1 * 4.4e3);
  const Peak peak = find_peak(rows_, scene);
  EXPECT_EQ(peak.force, largest);
  EXPECT_EQ(peak.displacement, there);

  const nlohmann::json head = head_of(outcome()), &summary = head.at("summary");
  EXPECT_EQ(summary.at("peak_vertical_force_N"), largest);
  EXPECT_TRUE(summary.at("peak_horizontal_force_N").is_null());
  EXPECT_EQ(summary.at("displacement_at_peak_m"), there);

  plot_curve(folder_, rows_, scene, "law", "");  // the script is kept, also without gnuplot
  EXPECT_NE(read_all(folder_ / "plots/curve.gp").find("vertical displacement of the top beam"), std::string::npos);
  std::istringstream curve(read_all(folder_ / "plots/curve.dat"));
  std::string line;
  std::getline(curve, line);
  double highest = 0.0, furthest = 0.0;  // kN, mm
  for (double x, force, stress; curve >> x >> force >> stress;)
    highest = std::max(highest, std::abs(force)), furthest = std::max(furthest, x);
  EXPECT_NEAR(highest, largest / 1e3, 1e-4 * highest);
  EXPECT_NEAR(furthest, rows_.back().monitor_displacement[1] * 1e3, 1e-4 * furthest);
}
INSTANTIATE_TEST_SUITE_P(Stages, UprightReport, ::testing::Values(kMeasuredUpright, kDrivenUpright));

// The report of a building in large motion is that of the lattice, with beams and equal intervals of rows.
TEST_F(Report, OfABuildingInLargeMotionIsThatOfTheLattice) {
  std::map<std::string, nlohmann::json> summaries;
  std::map<std::string, std::size_t> rows;
  for (const std::string motion : {"never", "always"}) {
    Simulation simulation(
        read_scene(QUOIN_TESTS "/host/small_building.toml",
                   {"solver.large_motion=" + motion, "stage.weight.duration=2e-4", "stage.push.ramp_time=1e-3",
                    "stage.push.displacement=5e-4", "stage.push.record_interval=0", "output.frames=0"}),
        2);
    struct Rows : Observer {
      std::vector<HistoryRow> all;
      void on_row(const HistoryRow& row) override { all.push_back(row); }
    } recorded;
    simulation.run(recorded);
    rows[motion] = static_cast<std::size_t>(
        std::count_if(recorded.all.begin(), recorded.all.end(), [](const HistoryRow& row) { return row.stage == 1; }));
    summaries[motion] = nlohmann::json::parse(summary_text(simulation, recorded.all, {}));
  }
  for (const char* key : {"blocks", "beams", "bed_area_m2"})
    EXPECT_EQ(summaries["always"].at(key), summaries["never"].at(key)) << key;
  EXPECT_EQ(summaries["always"].at("beams"), 3) << "below everything, and two of the floor";
  // Walls of 7 and 3 half units of 0.2 m, 0.25 m thick, and their corner.
  EXPECT_NEAR(summaries["always"].at("bed_area_m2").get<double>(), 10 * 0.2 * 0.25 + 0.25 * 0.25, 1e-12);
  // Intervals of rows are equal but for the difference of the time steps.
  const auto never = static_cast<double>(rows["never"]);
  EXPECT_GT(never, 100.0);
  EXPECT_NEAR(static_cast<double>(rows["always"]), never, 0.2 * never);
}

}  // namespace
}  // namespace quoin
