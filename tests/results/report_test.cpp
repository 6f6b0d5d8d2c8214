// The page of a run: its contents, and messages for damaged results.
#include "results/report.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/error.h"
#include "files/file.h"
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
