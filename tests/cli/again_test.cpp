// Runs that are repeated from their summaries, and warnings of runs that violate their assumptions.
#include <gmock/gmock.h>

#include <csignal>

#include "program.h"
#include "results/provenance.h"

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class Again : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    scene_ = (folder_ / "wall.toml").string();
    fs::copy_file(small_, scene_);
  }
  int run(std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", scene_, "--out", out(), "--threads", "2", "--set", "output.plots=false", "--set",
                               "stage.2.displacement=5e-5"});
    return quoin(more);
  }
  int again(std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"run", "--again", out()});
    return quoin(more);
  }
  nlohmann::json provenance() const { return summary()["provenance"]; }
  std::string scene_;
};

TEST_F(Again, SummariesSayWhatARunWasMadeFrom) {
  ASSERT_EQ(run({"--law", "coulomb_slip"}), 0) << error_;
  const nlohmann::json p = provenance();
  EXPECT_EQ(p["scene"]["text"], read_all(scene_));
  EXPECT_EQ(p["law"], "coulomb_slip");
  EXPECT_EQ(p["set"], nlohmann::json({"output.plots=false", "stage.2.displacement=5e-5"}));
  EXPECT_EQ(p["instruction_set"], summary()["instruction_set"]);
  EXPECT_TRUE(p["seed"].is_null()) << "no property scatters";
  // Hashes are those of sha256sum.
  const std::string library = p["laws"][0]["library"], list = (folder_ / "sums").string();
  std::ofstream(list) << p["laws"][0]["sha256"].get<std::string>() << "  " << library << "\n"
                      << p["program"]["sha256"].get<std::string>() << "  " << QUOIN_PROGRAM << "\n"
                      << p["scene"]["sha256"].get<std::string>() << "  " << scene_ << "\n"
                      << p["results"]["history_sha256"].get<std::string>() << "  " << out() << "/history.csv\n";
  EXPECT_EQ(finish(start({"/usr/bin/sha256sum", "--check", "--strict", list})), 0) << out_;
}

TEST_F(Again, SummariesHaveTheSeedOfWhatScatters) {
  const std::string settings = "joints.mortar.missing_mortar=0.1";
  ASSERT_EQ(run({"--set", settings, "--set", "random.seed=7"}), 0) << error_;
  EXPECT_EQ(provenance()["seed"], 7);
}

TEST_F(Again, SummariesNameTheMachine) {
  ASSERT_EQ(run(), 0) << error_;
  const nlohmann::json machine = provenance()["machine"];
  EXPECT_FALSE(machine["processor"].get<std::string>().empty());
  ASSERT_EQ(finish(start({"/usr/bin/uname", "-srm"})), 0);
  EXPECT_EQ(machine["system"].get<std::string>() + "\n", out_);
}

// Repeating a run does not need the scene file, since the summary contains the scene.
TEST_F(Again, RepeatedRunsHaveTheSameBits) {
  ASSERT_EQ(run(), 0) << error_;
  fs::remove(scene_);
  ASSERT_EQ(again(), 0) << error_;
  EXPECT_THAT(out_, AllOf(HasSubstr("the bits agree with " + out()),
                          HasSubstr(provenance()["results"]["state"].get<std::string>())));
  EXPECT_EQ(read_all(out() + "-again/history.csv"), read_all(out() + "/history.csv"));
  EXPECT_EQ(again({"--threads", "1", "--out", (folder_ / "third").string()}), 0) << error_;
  EXPECT_TRUE(fs::exists(folder_ / "third" / "history.csv"));
}

// Each file that a scene reads is held against itself, by name.
TEST_F(Again, FilesOfTheSceneAreThoseOfThen) {
  std::vector<std::string> records;
  std::string stages;
  for (const char* name : {"one", "two"}) {
    records.push_back((folder_ / (std::string(name) + ".csv")).string());
    std::ofstream(records.back()) << "time_s,ax_m_s2\n0,0\n0.001," << (name[0] == 'o' ? 1 : 2) << "\n0.002,0\n";
    stages += "[[stage]]\nname = \"" + std::string(name) +
              "\"\nduration = 0.002\nground_motion = { direction = [1, 0, 0], "
              "file = \"" +
              records.back() + "\" }\n";
  }
  std::ofstream(scene_, std::ios::app) << stages;
  ASSERT_EQ(run(), 0) << error_;
  ASSERT_EQ(again(), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("the bits agree"));
  std::ofstream(records.back(), std::ios::app) << "0.003,1\n";
  EXPECT_EQ(again({"--out", (folder_ / "third").string()}), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr(records.back()), HasSubstr("has changed since that run")));
}

// The history of the run itself is compared, not only its hash in the summary.
TEST_F(Again, AChangedHistoryIsTold) {
  ASSERT_EQ(run(), 0) << error_;
  std::string history = read_all(out() + "/history.csv");
  history.insert(history.rfind(','), "1");
  std::ofstream(out() + "/history.csv") << history;
  EXPECT_EQ(again(), 5) << error_;
  EXPECT_THAT(out_, AllOf(HasSubstr("history.csv is not what its run wrote"), HasSubstr("it differs at row")));
}

// A run that fails ends with its exit code, one that repeats it with that of the comparison.
TEST_F(Again, ARunThatFailedIsRepeated) {
  ASSERT_EQ(run({"--set", "stage.1.max_steps=100"}), 5) << error_;
  EXPECT_EQ(again(), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("the bits agree"));
}

TEST_F(Again, OtherBitsAreToldWithTheReason) {
  const std::string law = (folder_ / "my_law.so").string();
  fs::copy_file(fs::path(QUOIN_PROGRAM).parent_path() / "laws" / "elastic.so", law);
  ASSERT_EQ(run({"--law", law}), 0) << error_;
  std::ofstream(law, std::ios::app) << "rebuilt";
  ASSERT_EQ(again(), 0) << "the same code: " << error_;
  EXPECT_THAT(error_, HasSubstr("not as then: law " + law));
  fs::copy_file(fs::path(QUOIN_PROGRAM).parent_path() / "laws" / "coulomb_slip.so", law,
                fs::copy_options::overwrite_existing);
  // The other law needs other properties: refused, or another curve.
  const int code = again();
  EXPECT_TRUE(code == 4 || code == 5) << code << error_;
  if (code == 5) {
    EXPECT_THAT(out_, AllOf(HasSubstr("the bits differ from " + out()), HasSubstr("first at row"),
                            HasSubstr("Not as then: law " + law)));
  }
}

TEST_F(Again, WhatCannotBeRepeatedIsRefused) {
  EXPECT_EQ(again(), 3);
  EXPECT_THAT(error_, HasSubstr("summary.json"));
  ASSERT_EQ(run(), 0) << error_;
  nlohmann::json json = summary();
  const auto expect_refused = [&](const std::string& reason) {
    std::ofstream(out() + "/summary.json") << json.dump();
    EXPECT_EQ(again(), 3);
    EXPECT_THAT(error_, HasSubstr(reason));
  };
  json["provenance"]["scene"]["text"] = "title = 'another'";
  expect_refused("the text of the scene is not what was read then");
  json["provenance"].erase("scene");
  expect_refused("is not whole");
  json.erase("provenance");
  expect_refused("does not say what the run was made from");
  json = {{"status", "interrupted"}, {"provenance", {}}};
  expect_refused("--resume");
  EXPECT_EQ(quoin({"run", scene_, "--again", out()}), 2);
}

// A locale with decimal commas, no home directory, a locale that does not exist.
TEST_F(Again, SurroundingsChangeNothing) {
  ASSERT_EQ(run(), 0) << error_;
  const std::string history = read_all(out() + "/history.csv");
  for (const char* locale : {"de_DE.UTF-8", "nowhere"}) {
    EXPECT_EQ(quoin({"run", "--again", out()},
                    [locale] {
                      for (const char* name : {"LC_ALL", "LC_NUMERIC", "LANG"}) setenv(name, locale, 1);
                      unsetenv("HOME");
                    }),
              0)
        << error_;
    EXPECT_EQ(read_all(out() + "-again/history.csv"), history);
  }
}

// Checkpoints, rows and time limits use a monotonic clock.
TEST_F(Again, ClocksThatJumpChangeNothing) {
#ifdef QUOIN_SANITIZED
  GTEST_SKIP() << "a sanitizer wants to be the first library";
#endif
  ASSERT_EQ(run(), 0) << error_;
  const auto history = [this](const std::string& folder) { return read_all(folder + "/history.csv"); };
  EXPECT_EQ(quoin({"run", "--again", out(), "--checkpoint-every", "0.01"},
                  [] {
                    alarm(60);
                    setenv("LD_PRELOAD", QUOIN_JUMPING_CLOCK_LIBRARY, 1);
                  }),
            0)
      << error_;
  EXPECT_EQ(history(out() + "-again"), history(out()));
}

// A run whose output folder is removed ends with an error at the next checkpoint. The whole run would take minutes.
TEST_F(Again, FoldersThatVanishAreTold) {
  const pid_t child = start({QUOIN_PROGRAM, "run", scene_, "--out", out(), "--threads", "1", "--checkpoint-every",
                             "0.01", "--set", "output.plots=false", "--set", "stage.shear.velocity=1e-6"},
                            -1, [] { alarm(60); });
  while (!fs::exists(out() + "/checkpoint.bin") && waitpid(child, nullptr, WNOHANG) == 0) usleep(1000);
  std::error_code ignored;
  while (fs::exists(out())) fs::remove_all(out(), ignored);  // repeated, since the run may write there
  const int code = finish(child);
  EXPECT_EQ(code, 3) << error_;
  EXPECT_THAT(error_, AllOf(HasSubstr(out() + ": the folder has gone"), HasSubstr("--out")));
}

class Watched : public Again {};

// A pressure p on joints of stiffness k closes them by p / k = 6 mm, above the bound of 5 % of the blocks' 62.5 mm.
TEST_F(Watched, BlocksThatOverlapAreTold) {
  ASSERT_EQ(run({"--law", "elastic", "--set", "joints.mortar.normal_stiffness=5e7", "--set",
                 "joints.mortar.shear_stiffness=2e7"}),
            0)
      << error_;
  const std::string reported = "warning: blocks overlap by ";
  EXPECT_THAT(error_, HasSubstr(reported));
  EXPECT_EQ(error_.find(reported, error_.find(reported) + 1), std::string::npos) << "once";
  EXPECT_EQ(summary()["warnings"][0]["about"], "interpenetration");
  const double overlap = summary()["watch"]["largest_overlap_m"];
  EXPECT_GE(overlap, 0.3e6 / 5e7);
  EXPECT_LE(overlap, 2.0 * 0.3e6 / 5e7) << "twice that is what a load that comes at once swings to";
  EXPECT_NEAR(summary()["watch"]["overlap_allowed_m"].get<double>(), 0.05 * 0.0625, 1e-12);
}

TEST_F(Watched, GoodRunsAreQuiet) {
  ASSERT_EQ(run({"--set", "stage.2.displacement=5e-4"}), 0) << error_;
  const nlohmann::json all = summary(), watch = all["watch"];
  EXPECT_LT(std::abs(watch["energy_missing_over_moved"].get<double>()), 0.05);
  EXPECT_LE(watch["stiffness_over_bound"].get<double>(), 1.0 + 1e-9);
  for (const auto& warning : all["warnings"]) EXPECT_EQ(warning["about"], "quasi_static") << warning;
}

TEST_F(Watched, PicturesSayWhatTheRunHasLeft) {
  ASSERT_EQ(quoin({"run", scene_, "--out", out(), "--threads", "1", "--set", "stage.2.displacement=1e-5", "--law",
                   "elastic", "--set", "joints.mortar.normal_stiffness=5e7", "--set",
                   "joints.mortar.shear_stiffness=2e7", "--set", "output.frames=0"}),
            0)
      << error_;
  for (const char* picture : {"curve", "cracks"})
    EXPECT_THAT(read_all(out() + "/plots/" + picture + ".gp"),
                HasSubstr("Warnings, see summary.json: interpenetration"));
}

TEST(Provenance, EachDifferenceIsNamedWithBothValues) {
  quoin::Provenance here;
  here.program = "1", here.program_sha256 = "0123456789abcdef", here.compiler = "c";
  here.laws = {{"elastic", "", "aa"}, {"mine", "", "bb"}}, here.inputs = {{"wall.obj", "", "cc"}};
  here.instruction_set = "AVX2";
  EXPECT_TRUE(quoin::differences(here, here).empty());
  quoin::Provenance there = here;
  there.compiler = "d", there.laws = {{"elastic", "", "ab"}}, there.inputs.front().name = "other.obj";
  there.instruction_set = "";
  EXPECT_THAT(quoin::differences(here, there),
              ::testing::ElementsAre("program: 1 (sha256 0123456789ab, c), there 1 (sha256 0123456789ab, d)",
                                     "law elastic: sha256 aa, there sha256 ab", "law mine: sha256 bb, there none",
                                     "file wall.obj: sha256 cc, there none", "instruction set: AVX2, there none"));
}

}  // namespace
