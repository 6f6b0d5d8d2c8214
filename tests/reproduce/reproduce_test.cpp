// The studies: the list, a study without runs, a small study with runs, and the curves from which verdicts are
// computed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "files/result_folder.h"
#include "reproduce/building_layouts.h"
#include "reproduce/chart.h"
#include "reproduce/curve.h"
#include "reproduce/page.h"
#include "reproduce/study.h"
#include "reproduce/verdict_file.h"
#include "scene/generate.h"
#include "scene/read_scene.h"

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

std::string read_all(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Reproduce : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              (std::string("quoin_reproduce_") + ::testing::UnitTest::GetInstance()->current_test_info()->name() + "_" +
               std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  int quoin(const std::string& arguments) {
    const std::string command = "QUOIN_SCENES='" QUOIN_SCENES "' '" QUOIN_PROGRAM "' reproduce " + arguments + " > '" +
                                (folder_ / "stdout").string() + "' 2> '" + (folder_ / "stderr").string() + "'";
    const int status = std::system(command.c_str());
    out_ = read_all(folder_ / "stdout");
    error_ = read_all(folder_ / "stderr");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  }
  std::string results() const { return "--out '" + (folder_ / "results").string() + "'"; }

  fs::path folder_;
  std::string out_, error_;
};

TEST_F(Reproduce, ListNamesEveryStudy) {
  ASSERT_EQ(quoin("--list"), 0);
  for (const char* id :
       {"law", "walls", "rate", "brittle", "envelope", "hollow", "contact_points", "stiffness", "block_size", "energy",
        "building", "blind", "cyclic", "cyclic_wall", "cyclic_piers", "cyclic_building", "restrained_dilation"})
    EXPECT_THAT(out_, HasSubstr(id));
}

TEST_F(Reproduce, UnknownStudyIsRefused) {
  EXPECT_EQ(quoin("wals " + results()), 2);
  EXPECT_THAT(error_, HasSubstr("wals"));
}

TEST_F(Reproduce, LawKeepsTheNumbersOfTable1) {
  ASSERT_EQ(quoin("law " + results()), 0) << error_;
  EXPECT_THAT(out_, Not(HasSubstr("NOT reproduced")));
  const auto verdicts = nlohmann::json::parse(read_all(folder_ / "results/verdict.json"));
  EXPECT_EQ(verdicts.size(), 10u);
  for (const auto& v : verdicts) {
    for (const char* key : {"study", "claim", "number", "reference", "unit", "kind", "reproduced"})
      EXPECT_TRUE(v.contains(key)) << key;
    EXPECT_NEAR(v["number"].get<double>() / v["reference"].get<double>(), 1.0, 0.01) << v["claim"];
  }
  EXPECT_THAT(read_all(folder_ / "results/index.html"), HasSubstr("The law of a joint"));
  EXPECT_TRUE(fs::exists(folder_ / "results/law/curves.csv"));
}

TEST_F(Reproduce, OneProgramAtATimeWritesAFolder) {
  {
    const quoin::FolderLock lock(folder_ / "results");
    EXPECT_EQ(quoin("law " + results()), 3);
    EXPECT_THAT(error_, HasSubstr("in use by another run (process " + std::to_string(getpid())));
    EXPECT_FALSE(fs::exists(folder_ / "results/index.html"));
  }
  EXPECT_EQ(quoin("law " + results()), 0) << error_;
}

// Names of folders, texts of programs and texts of scenes in messages and legends are neither markup nor commands.
TEST_F(Reproduce, TextIsNeitherMarkupNorCommand) {
  using namespace quoin::reproduce;
  const std::string hostile =
      "<script>alert('x')</script> \"onload=\"x\" & `touch " + (folder_ / "canary").string() + "`";
  StudyReport report;
  for (auto* list : {&report.agrees, &report.differs, &report.seen, &report.notes, &report.notices})
    list->push_back(hostile);
  report.verdicts.push_back({hostile, 1.0, 2.0, hostile, Kind::printed, false, hostile});
  report.tables.push_back({hostile, {hostile}, {{hostile}}});
  const Study study{"law", hostile, hostile, hostile, nullptr, nullptr};
  const Findings findings(folder_, "law", qualities()[0], {});
  Chart chart{.name = "chart", .title = hostile, .x_label = hostile, .y_label = hostile};
  chart.add_points(hostile, {1.0, 2.0}, {1.0, 2.0}, 0);
  chart.add_level(hostile, Kind::printed, 1.5, 1);
  draw(chart, findings, report, hostile);
  EXPECT_TRUE(fs::exists(folder_ / "law/chart.png"));
  EXPECT_FALSE(fs::exists(folder_ / "canary")) << "a command was run";

  report.pictures.push_back({"runs/a \"b\" <c>&?#%/cracks.png", hostile});
  write_section(folder_, study, qualities()[0], report);
  std::ofstream(folder_ / "verdict.json") << nlohmann::json{
      {{"study", hostile}, {"claim", hostile}, {"unit", hostile}, {"kind", hostile}, {"reference", 1.0}}, "no verdict"};
  write_page(folder_);
  for (const char* file : {"law/section.html", "index.html"}) {
    const std::string page = read_all(folder_ / file);
    EXPECT_THAT(page,
                HasSubstr("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &quot;onload=&quot;x&quot; &amp; `touch"));
    EXPECT_THAT(page, Not(HasSubstr("<script")));
    EXPECT_THAT(page, Not(HasSubstr("\"onload")));
    EXPECT_THAT(page, HasSubstr("href=\"runs/a%20%22b%22%20%3Cc%3E%26%3F%23%25/cracks.png\""));
  }
}

// Two courses of one unit, moved by 20 micrometres, which takes seconds. The verdicts have no meaning here.
TEST_F(Reproduce, RunsAreComputedOnceAndUnfinishedOnesAgain) {
  const std::string tiny =
      "energy --quality fast --set wall.courses=2 --set wall.units_per_course=1 "
      "--set stage.shear.displacement=2e-5 --set stage.shear.ramp_time=1e-4 " +
      results();
  ASSERT_EQ(quoin(tiny), 0) << error_;
  EXPECT_THAT(error_, HasSubstr("4 runs, 0 of them done before"));
  int runs = 0;
  fs::path one;
  for (const auto& entry : fs::directory_iterator(folder_ / "results/runs")) {
    EXPECT_EQ(nlohmann::json::parse(read_all(entry.path() / "summary.json"))["status"], "done");
    one = entry.path();
    ++runs;
  }
  EXPECT_EQ(runs, 4);
  EXPECT_THAT(read_all(folder_ / "results/energy/curves.csv"), HasSubstr("x 0.5"));
  const auto verdicts = nlohmann::json::parse(read_all(folder_ / "results/verdict.json"));
  EXPECT_EQ(verdicts.size(), 2u);

  ASSERT_EQ(quoin(tiny), 0) << error_;
  EXPECT_THAT(error_, Not(HasSubstr("done before")));  // nothing was left to do

  // As after Ctrl-C: only that run starts again.
  std::ofstream(one / "summary.json") << R"({"status": "interrupted", "interrupted": true})";
  ASSERT_EQ(quoin(tiny), 0) << error_;
  EXPECT_THAT(error_, HasSubstr("4 runs, 3 of them done before"));

  // An additional study does not change the page and the verdicts of the first one.
  ASSERT_EQ(quoin("law " + results()), 0) << error_;
  const std::string page = read_all(folder_ / "results/index.html");
  EXPECT_THAT(page, HasSubstr("Fracture energies"));
  EXPECT_THAT(page, HasSubstr("The law of a joint"));
  EXPECT_EQ(nlohmann::json::parse(read_all(folder_ / "results/verdict.json")).size(), 12u);

  // With another binary of the law all runs are computed again.
  const fs::path law = folder_ / "laws/fracture_energy.so";
  fs::create_directories(law.parent_path());
  fs::copy_file(QUOIN_FRACTURE_ENERGY, law);
  std::ofstream(law, std::ios::app) << "a byte that changes nothing but the file";
  setenv("QUOIN_LAW_PATH", law.parent_path().c_str(), 1);
  ASSERT_EQ(quoin(tiny), 0) << error_;
  unsetenv("QUOIN_LAW_PATH");
  EXPECT_THAT(error_, HasSubstr("4 runs, 0 of them done before"));
}

// Without a run there is no claim; the cause is an input (3).
TEST_F(Reproduce, RunsThatAreRefusedReproduceNothing) {
  EXPECT_EQ(quoin("walls --quality fast --set solver.nokey=1 " + results()), 3) << error_;
  EXPECT_THAT(out_, AllOf(HasSubstr("1 of 1 studies not evaluated, as runs are missing"), Not(HasSubstr("every"))));
}

// This small wall at the time step of eq. 3: the run fails, which is its result, and is not repeated.
TEST_F(Reproduce, RunsThatMayFailAreResults) {
  const std::string tiny =
      "rate --quality fast --set wall.courses=2 --set wall.units_per_course=1 "
      "--set stage.shear.displacement=2e-5 --set stage.shear.ramp_time=1e-4 " +
      results();
  ASSERT_EQ(quoin(tiny), 0) << error_;
  int failed = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "results/runs"))
    failed += nlohmann::json::parse(read_all(entry.path() / "summary.json"))["status"] == "failed";
  EXPECT_GE(failed, 1);
  EXPECT_THAT(read_all(folder_ / "results/rate/section.html"), HasSubstr("numerical failure at step"));
  EXPECT_EQ(nlohmann::json::parse(read_all(folder_ / "results/verdict.json")).size(), 2u);
  ASSERT_EQ(quoin(tiny), 0) << error_;
  EXPECT_THAT(error_, Not(HasSubstr("done before")));  // nothing was left to do
}

TEST(Curve, ReadsWhatPeopleRead) {
  quoin::reproduce::Curve curve;
  for (int i = 0; i <= 400; ++i) {
    const double d = 0.01 * i;
    curve.stage.push_back(2);
    curve.displacement.push_back(d);
    curve.force.push_back(d <= 2 ? 10 * d : 20 - 5 * (d - 2));
    curve.vertical.push_back(30.0);
    curve.unbalanced.push_back(0.1);
  }
  EXPECT_DOUBLE_EQ(curve.peak(), 20.0);
  EXPECT_NEAR(curve.peak_displacement(), 2.0, 1e-12);
  EXPECT_NEAR(curve.force_at(1.234), 12.34, 1e-9);
  EXPECT_NEAR(curve.displacement_after_peak(0.8), 2.8, 0.011);
  EXPECT_LT(curve.displacement_after_peak(0.4), 0.0);
  EXPECT_DOUBLE_EQ(curve.largest_fall(2.0), 0.0);
  EXPECT_NEAR(curve.largest_fall(3.0), 0.25, 1e-9);
  EXPECT_LT(curve.roughness(0.05, 0.1, 1.9), 1e-12);
  // 0.1 up to 1 mm, 0.3 from there to 2 mm, with one row before the first load: 50 and 100 rows, including both ends.
  for (std::size_t i = 101; i <= 200; ++i) curve.unbalanced[i] = 0.3;
  curve.unbalanced[60] = HUGE_VAL;
  EXPECT_NEAR(curve.mean_unbalanced(0.505, 2.005), (49 * 0.1 + 100 * 0.3) / 149, 1e-12);
  EXPECT_EQ(curve.mean_unbalanced(5.0, 6.0), 0.0);
  // The rest is a wave of amplitude a, much shorter than the window: a / sqrt(2).
  for (std::size_t i = 0; i < curve.size(); ++i)
    curve.force[i] += 0.2 * std::sin(2 * M_PI * curve.displacement[i] / 0.05);
  EXPECT_NEAR(curve.roughness(0.05, 0.1, 1.9), 0.2 / std::sqrt(2.0) / curve.peak(), 0.1 * 0.2 / curve.peak());
}

// Every layout of the runs is a scene with the numbers of blocks and half units of the layout. Corners count as one
// half unit in the layout and have half of its zones in the scene.
TEST(Layouts, AreScenesWithTheNumbersOfTable2) {
  using namespace quoin::reproduce;
  const auto blocks_and_zones = [](const std::string& scene, const std::vector<std::string>& overrides) {
    const quoin::Assembly assembly =
        quoin::assemble(quoin::read_scene(std::string(QUOIN_SCENES "/") + scene, overrides));
    std::pair<int, int> count{-1, 0};  // without the bottom beam
    for (const quoin::Brick& b : assembly.bricks) {
      ++count.first;
      if (!b.rigid) count.second += 5 * b.zones[0] * b.zones[1] * b.zones[2];
    }
    return count;
  };
  EXPECT_EQ(blocks_and_zones("pavia_door.toml", {}), std::pair(996, 81600));
  int fitting = 0;
  for (const DoorLayout& layout : door_layouts()) {
    EXPECT_EQ(layout.count().blocks, kTableD.blocks);
    EXPECT_EQ(layout.count().half_units, kTableD.half_units);
    if (!why_not(layout).empty()) continue;
    ++fitting;
    EXPECT_EQ(blocks_and_zones("pavia_door.toml", layout.overrides()), std::pair(996, 81600)) << layout.name();
  }
  EXPECT_EQ(fitting, 3);
  fitting = 0;
  for (const WindowLayout& layout : window_layouts()) {
    const Count count = layout.count();
    EXPECT_LE(std::abs(count.blocks - kTableABC.blocks), 2);
    EXPECT_LE(std::abs(count.half_units - kTableABC.half_units), 2);
    if (!why_not(layout).empty()) continue;
    ++fitting;
    const auto [blocks, zones] = blocks_and_zones("pavia_window.toml", layout.overrides());
    // In layouts in which beams count separately, 22 half units of the wall are beams.
    const int besides = layout.beams_besides ? 22 : 0;
    EXPECT_EQ(blocks, count.blocks - besides) << layout.name();
    EXPECT_EQ(zones, kZonesPerHalfUnit * (count.half_units - 2 * besides - 40)) << layout.name();
  }
  EXPECT_EQ(fitting, 3);
}

TEST(Curve, KeptRunsWithRowsThatAreNoNumbersAreRefused) {
  const fs::path file = fs::temp_directory_path() / ("quoin_torn_" + std::to_string(getpid()) + ".csv");
  std::ofstream(file) << "stage,time_s,displacement_m,horizontal_force_N,vertical_force_N,unbalanced_ratio\n"
                         "2,0.1,1e-3,5e3,1e3,0\n2,0.2,1e-3,5e3x,1e3,0\n";
  try {
    quoin::reproduce::read_history(file, 2);
    ADD_FAILURE() << "accepted";
  } catch (const quoin::Error& error) {
    EXPECT_EQ(error.exit_code, quoin::Exit::bad_input);
    EXPECT_THAT(error.what(), ::testing::AllOf(HasSubstr("horizontal_force_N '5e3x'"), HasSubstr("--again")));
  }
  fs::remove(file);
}

TEST(Curve, DistanceIsTheLargestGapOverThePeakOfTheSecond) {
  quoin::reproduce::Curve low, high;
  for (int i = 0; i <= 100; ++i) {
    for (auto* c : {&low, &high}) c->displacement.push_back(0.01 * i);
    low.force.push_back(0.1 * i);
    high.force.push_back(i < 50 ? 0.1 * i : 0.1 * i + 2.0);  // peak 12
  }
  EXPECT_NEAR(quoin::reproduce::curve_distance(low, high, 0.1, 0.45), 0.0, 1e-9);
  EXPECT_NEAR(quoin::reproduce::curve_distance(low, high, 0.1, 0.9), 100.0 * 2.0 / 12.0, 1e-9);
}

// "As printed" runs have eq. 1 for all qualities; only those with steps above 1/sqrt(1.8) of 2/omega_max may fail.
TEST(Studies, PrintedRunsAreEquation1) {
  using quoin::reproduce::printed_run;
  const auto sound = printed_run("a", "solid_wall_121", 0.01, 0.0025, 0.74);
  for (const char* o : {"solver.damping=local", "solver.local_damping=0.8", "solver.time_step_fraction=0.74",
                        "stage.shear.velocity=0.01", "stage.shear.displacement=0.0025", "stage.shear.ramp_time=0"})
    EXPECT_THAT(sound.overrides, ::testing::Contains(std::string(o)));
  EXPECT_EQ(sound.overrides.size(), 6u);
  EXPECT_FALSE(sound.may_fail);
  EXPECT_TRUE(printed_run("b", "solid_wall_121", 0.01, 0.0025, 0.75).may_fail);
}

TEST(Studies, ThirteenAreOfThePaper) {
  const auto& all = quoin::reproduce::studies();
  EXPECT_EQ(std::count_if(all.begin(), all.end(), [](const auto& study) { return !study.beyond; }), 13);
  EXPECT_EQ(quoin::reproduce::verdict_file("out", *quoin::reproduce::find_study("cyclic")).string(),
            "out/verdict.json");
  EXPECT_EQ(quoin::reproduce::verdict_file("out", *quoin::reproduce::find_study("cyclic_wall")).string(),
            "out/beyond.json");
}

TEST(Studies, HaveRunsWithNamesOfTheirOwn) {
  for (const auto& quality : quoin::reproduce::qualities()) {
    for (const auto& study : quoin::reproduce::studies()) {
      std::vector<std::string> names;
      for (const auto& run : study.runs(quality)) {
        EXPECT_TRUE(fs::exists(fs::path(QUOIN_SCENES) / (run.scene + ".toml"))) << run.scene;
        names.push_back(run.name);
      }
      std::sort(names.begin(), names.end());
      EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end()) << study.id;
    }
  }
}

}  // namespace
