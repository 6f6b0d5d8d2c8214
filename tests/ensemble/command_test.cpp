// `quoin ensemble` as a process: many processes with one folder, and some of them killed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include "base/error.h"
#include "ensemble/sensitivity.h"
#include "program.h"

namespace {

using testing::AllOf;
using testing::HasSubstr;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::stringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

constexpr const char* kVariedDensity =
    "[[quantity]]\nkey = \"materials.stone.density\"\ndistribution = \"uniform\"\nlower = 1900.0\nupper = 2100.0\n";

class Ensemble : public Cli {
 protected:
  std::vector<std::string> words(const std::string& out, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {QUOIN_PROGRAM, "ensemble", study_, "--out", (folder_ / out).string(), "--no-pictures"});
    return more;
  }
  int ensemble(const std::string& out, const std::vector<std::string>& more = {}) {
    return finish(start(words(out, more)));
  }
  // Runs the study that the test has written, study.toml.
  int written_study(const std::string& out, std::vector<std::string> more = {}) {
    more.insert(more.begin(),
                {QUOIN_PROGRAM, "ensemble", (folder_ / "study.toml").string(), "--out", (folder_ / out).string()});
    return finish(start(more));
  }
  std::string table(const std::string& out) const { return read_all(folder_ / out / "samples.csv"); }
  int finished(const std::string& out) const {
    int count = 0;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder_ / out / "samples", none))
      count += fs::exists(entry.path() / "sample.json") ? 1 : 0;
    return count;
  }
  void wait_until_finished(const std::string& out, int samples) const {
    for (int i = 0; i < 3000 && finished(out) < samples; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  // Returns the processes with the folder in their command line.
  std::vector<pid_t> processes(const std::string& out) const {
    std::vector<pid_t> found;
    for (const auto& entry : fs::directory_iterator("/proc")) {
      const std::string name = entry.path().filename().string();
      if (name.find_first_not_of("0123456789") != std::string::npos) continue;
      std::ostringstream words;  // empty if the process ends meanwhile
      words << std::ifstream(entry.path() / "cmdline").rdbuf();
      if (words.str().find((folder_ / out).string()) != std::string::npos) found.push_back(std::stoi(name));
    }
    return found;
  }
  const std::string study_ = QUOIN_ENSEMBLE_TESTS "/small_study.toml";
};

// Samples that slide under collapse.start already have no multiplier. They counted as not having reached the limit, so
// the weakest as the strongest.
TEST_F(Ensemble, SamplesWithoutAMultiplierHaveFailed) {
  std::ofstream(folder_ / "cube.toml") << dry_stone(30) << kCubeOnGround << R"([[stage]]
name = "push"
gravity = [0, -9.81, 0]
ramp_time = 0.2
collapse = { direction = [1, 0, 0], start = 0.3, rate = 0.2, displacement = 0.01 }
[output]
frames = 0
plots = false
)";
  std::ofstream(folder_ / "study.toml") << R"(scene = "cube.toml"
samples = 6
seed = 1
[[quantity]]
name = "phi"
key = "joints.dry.friction_angle"
distribution = "uniform"
lower = 5.0
upper = 30.0
[[fragility]]
name = "collapse"
output = "collapse_multiplier"
)";
  ASSERT_EQ(written_study("a", {"--no-pictures", "--jobs", "1"}), 0) << error_;
  int failed = 0, done = 0;
  for (const std::string& line : lines_of(table("a"))) {
    failed += line.find("the collapse multiplier is not known") != std::string::npos ? 1 : 0;
    done += line.find(",done,,") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(failed, 0);
  EXPECT_GT(done, 0);
  EXPECT_EQ(failed + done, 6);
  const auto results = nlohmann::json::parse(read_all(folder_ / "a" / "summary.json"));
  EXPECT_EQ(results["failed"], failed);
}

TEST_F(Ensemble, WritesOneRowASampleAndWhatTheyAddUpTo) {
  ASSERT_EQ(ensemble("a", {"--jobs", "2"}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("6 of 6 samples finished, 0 of them failed"));
  EXPECT_THAT(error_, HasSubstr("7/7 samples, ")) << "with the one of the means";
  const auto lines = lines_of(table("a"));
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_THAT(lines[0], testing::StartsWith("sample,status,reason,\"pressure\",\"joints.mortar.cohesion_mean\""));
  EXPECT_THAT(lines[0], HasSubstr(",peak_force_N,displacement_at_peak_m,"));
  for (std::size_t i = 1; i < lines.size(); ++i)
    EXPECT_THAT(lines[i], testing::StartsWith(fmt::format("{},done,,", i)));
  const auto results = nlohmann::json::parse(read_all(folder_ / "a" / "summary.json"));
  EXPECT_EQ(results["finished"], 6);
  const auto& peak = results["outputs"]["peak_force_N"];
  EXPECT_LT(peak["mean_95"][0], peak["mean"]);
  EXPECT_GT(peak["of_means"], 0.0);
  EXPECT_THAT(read_all(folder_ / "a" / "index.html"), HasSubstr("small wall with scattered joints"));
  // Repeating the command computes nothing. With more samples the first rows do not change.
  const std::string first = table("a");
  ASSERT_EQ(ensemble("a"), 0);
  EXPECT_EQ(table("a"), first);
  ASSERT_EQ(ensemble("a", {"--samples", "8"}), 0) << error_;
  EXPECT_THAT(table("a"), testing::StartsWith(first));
  EXPECT_EQ(lines_of(table("a")).size(), 9u);
  // A sample is an ordinary run: `quoin run` has equal results.
  const auto run = nlohmann::json::parse(read_all(folder_ / "a" / "samples" / "000002" / "summary.json"));
  std::vector<std::string> again{QUOIN_PROGRAM,       "run", small_, "--out", out(), "--threads", "1", "--set",
                                 "output.plots=false"};
  for (const auto& o : run["set"]) again.insert(again.end(), {"--set", o.get<std::string>()});
  ASSERT_EQ(finish(start(again)), 0) << error_;
  EXPECT_EQ(summary()["peak_horizontal_force_N"], run["peak_horizontal_force_N"]);
}

// A user's own samples.csv was replaced without a word. A folder that has study.json belongs to the study.
TEST_F(Ensemble, AFileOfTheUserIsKept) {
  fs::create_directories(folder_ / "a");
  std::ofstream(folder_ / "a" / "samples.csv") << "mine";
  EXPECT_EQ(ensemble("a"), 3);
  EXPECT_THAT(error_, HasSubstr("has samples.csv, which would be replaced"));
  EXPECT_EQ(table("a"), "mine");
  fs::remove(folder_ / "a" / "samples.csv");
  ASSERT_EQ(ensemble("a", {"--samples", "2"}), 0) << error_;
  fs::remove(folder_ / "a" / ".quoin-files");  // as of a study of an earlier version
  EXPECT_EQ(ensemble("a", {"--samples", "2"}), 0) << error_;
}

// Curves and cracks of the study come from tables of its samples. One that was cut or deleted made the bands of all
// empty, or wrong, without a word.
TEST_F(Ensemble, ATableThatIsNotWhatTheSampleWroteIsNamed) {
  ASSERT_EQ(ensemble("a", {"--jobs", "2", "--no-pictures"}), 0) << error_;
  const fs::path sample = folder_ / "a" / "samples" / "000003", file = sample / "history.csv";
  fs::resize_file(file, 1000);
  EXPECT_EQ(ensemble("a", {"--jobs", "2", "--no-pictures"}), 3);
  EXPECT_THAT(error_, HasSubstr("000003/history.csv: is missing or has not the"));
  fs::remove(sample / "sample.json");
  ASSERT_EQ(ensemble("a", {"--jobs", "2", "--no-pictures"}), 0) << error_;
  fs::remove(sample / "cracks.csv");
  EXPECT_EQ(ensemble("a", {"--jobs", "2", "--no-pictures"}), 3);
}

// Data of the pictures of a study: kN and mm, from the rows of its samples.
TEST_F(Ensemble, PicturesAreDrawnFromTheTable) {
  ASSERT_EQ(finish(start({QUOIN_PROGRAM, "ensemble", study_, "--out", (folder_ / "p").string()})), 0) << error_;
  const auto cells = [](const std::string& line, char by) {
    std::vector<std::string> found;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, by);) found.push_back(cell);
    return found;
  };
  const auto samples = lines_of(table("p"));
  const auto names = cells(samples[0], ',');
  const auto column = [&](const std::string& name) {
    const auto at = std::size_t(std::find(names.begin(), names.end(), name) - names.begin());
    std::vector<double> values;
    for (std::size_t i = 1; i < samples.size(); ++i) values.push_back(std::stod(cells(samples[i], ',').at(at)));
    return values;
  };
  const auto rows_of = [&](const char* file) {
    std::vector<std::vector<double>> rows;
    for (const std::string& line : lines_of(read_all(folder_ / "p" / "plots" / file))) {
      if (line.empty()) continue;
      rows.emplace_back();
      for (const std::string& cell : cells(line.substr(0, line.find(" \"")), ' '))
        rows.back().push_back(std::stod(cell));
    }
    return rows;
  };
  const std::vector<double> peaks = column("peak_force_N");
  ASSERT_EQ(peaks.size(), 6u);
  const auto convergence = rows_of("convergence.dat");
  ASSERT_EQ(convergence.size(), 4u);
  const double student[] = {4.302653, 3.182446, 2.776445, 2.570582};  // 97.5 %, for 2 to 5 degrees of freedom
  for (std::size_t n = 3; n <= 6; ++n) {
    double mean = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < n; ++i) mean += peaks[i] / 1e3 / double(n);
    for (std::size_t i = 0; i < n; ++i) squares += (peaks[i] / 1e3 - mean) * (peaks[i] / 1e3 - mean);
    const double half = student[n - 3] * std::sqrt(squares / double(n - 1) / double(n));
    const auto& row = convergence[n - 3];
    EXPECT_EQ(row[0], double(n));
    EXPECT_NEAR(row[1], mean, 1e-6 * mean);
    EXPECT_NEAR(row[2], mean - half, 1e-5 * mean);
    EXPECT_NEAR(row[3], mean + half, 1e-5 * mean);
  }
  // Force at each displacement, up to the 0.2 mm of the stage: the run with all means, and 5, 16, 50, 84, 95 %.
  const auto bands = rows_of("bands.dat");
  ASSERT_GT(bands.size(), 50u);
  EXPECT_EQ(bands.front()[0], 0.0);
  EXPECT_NEAR(bands.back()[0], 0.2, 2e-3);
  const double least = *std::min_element(peaks.begin(), peaks.end()) / 1e3,
               most = *std::max_element(peaks.begin(), peaks.end()) / 1e3;
  double highest = 0.0, of_means = 0.0;
  for (const auto& row : bands) {
    ASSERT_EQ(row.size(), 8u);
    EXPECT_TRUE(std::is_sorted(row.begin() + 3, row.end()));
    EXPECT_TRUE(row[1] >= row[3] - 1e-9 && row[1] <= row[7] + 1e-9);
    highest = std::max(highest, row[7]), of_means = std::max(of_means, row[2]);
  }
  EXPECT_LE(highest, most * (1 + 1e-6));
  EXPECT_GE(highest, least);
  const auto results = nlohmann::json::parse(read_all(folder_ / "p" / "summary.json"));
  EXPECT_NEAR(of_means, results["outputs"]["peak_force_N"]["of_means"].get<double>() / 1e3, 0.02 * most);
  // Sorted displacements at the peak, each at the middle of its step of probability, and a fitted distribution.
  std::vector<double> at_peak = column("displacement_at_peak_m");
  std::sort(at_peak.begin(), at_peak.end());
  const auto fragility = rows_of("fragility.dat");
  ASSERT_GE(fragility.size(), at_peak.size());
  for (std::size_t i = 0; i < at_peak.size(); ++i) {
    EXPECT_NEAR(fragility[i][0], at_peak[i], 1e-7 * at_peak[i]);
    EXPECT_NEAR(fragility[i][1], (double(i) + 0.5) / 6, 1e-7);
    EXPECT_TRUE(fragility[i][2] >= 0.0 && fragility[i][2] <= 1.0);
  }
  for (const char* picture : {"bands", "convergence", "fragility"}) {
    EXPECT_TRUE(fs::exists(folder_ / "p" / (std::string(picture) + ".png"))) << picture;
    EXPECT_THAT(read_all(folder_ / "p" / "index.html"), HasSubstr(std::string("src=\"") + picture + ".png\""));
  }
  const std::string script = read_all(folder_ / "p" / "plots" / "bands.gp");
  EXPECT_THAT(script, AllOf(HasSubstr("\"displacement, mm\""), HasSubstr("\"horizontal force, kN\"")));
}

// Correlated quantities of a study: the second has 0.6 of the first one's normal variable, and 0.8 of its own.
TEST_F(Ensemble, QuantitiesGoTogetherAsGiven) {
  const fs::path file = folder_ / "together.toml";
  const auto write = [&](const std::string& correlation) {
    std::ofstream(file) << "scene = \"" << small_ << "\"\nsamples = 400\ncorrelation = " << correlation << '\n'
                        << "[[quantity]]\nname = \"E\"\nkey = \"materials.brick.young_modulus\"\ndistribution = "
                           "\"normal\"\nmean = 10e9\nsd = 1e9\n"
                        << "[[quantity]]\nname = \"p\"\nkey = \"stage.precompression.pressure\"\ndistribution = "
                           "\"normal\"\nmean = 1e6\nsd = 1e4\n";
  };
  write("[[\"E\", \"p\", 0.6]]");
  const auto study = quoin::ensemble::read_study(file.string());
  EXPECT_THAT(study.mix, testing::Pointwise(testing::DoubleNear(1e-12), {1.0, 0.0, 0.6, 0.8}));
  double products = 0.0;
  for (std::uint64_t i = 1; i <= 400; ++i) {
    const auto values = study.values(i);
    products += (values[0] / 1e9 - 10.0) * (values[1] / 1e4 - 100.0) / 400;
  }
  EXPECT_NEAR(products, 0.6, 5 * std::sqrt(1.36 / 400)) << "variance of a product: 1 + 0.6^2";
  for (const char* wrong : {"[[\"E\", \"q\", 0.6]]", "[[\"q\", \"p\", 0.6]]", "[[\"E\", \"E\", 0.6]]",
                            "[[\"E\", \"p\", 1.0]]", "[[\"E\", \"p\", 0.9], [\"p\", \"E\", -0.9]]"}) {
    write(wrong);
    EXPECT_THROW(quoin::ensemble::read_study(file.string()), quoin::Error) << wrong;
  }
}

// The displacement at which the force is a fifth below the peak, from the history of a sample that reaches it.
TEST_F(Ensemble, LossOfAFifthIsThatOfTheHistory) {
  ASSERT_EQ(ensemble("a", {"--samples", "1", "--set", "stage.shear.displacement=0.001"}), 0) << error_;
  EXPECT_THAT(out_, HasSubstr(" kN on average; with everything"));  // one sample has no scatter
  const auto cells = [](const std::string& line) {
    std::vector<std::string> found;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) found.push_back(cell);
    return found;
  };
  const auto column = [&](const std::string& head, const char* name) {
    const auto names = cells(head);
    return std::size_t(std::find(names.begin(), names.end(), name) - names.begin());
  };
  const auto rows = lines_of(read_all(folder_ / "a" / "samples" / "000001" / "history.csv"));
  const auto samples = lines_of(table("a"));
  const std::size_t of_force = column(rows[0], "horizontal_force_N"), of_way = column(rows[0], "displacement_m"),
                    of_loss = column(samples[0], "displacement_at_20_percent_loss_m");
  ASSERT_LT(of_loss, cells(samples[1]).size());
  double peak = 0.0, loss = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const auto row = cells(rows[i]);
    if (row[0] != "2") continue;
    const double force = std::abs(std::stod(row[of_force]));
    if (force > peak) peak = force, loss = 0.0;
    if (loss == 0.0 && force <= 0.8 * peak) loss = std::abs(std::stod(row[of_way]));
  }
  EXPECT_GT(loss, 1e-4) << "nothing was lost";
  EXPECT_DOUBLE_EQ(std::stod(cells(samples[1])[of_loss]), loss);
}

// Three inputs: rows of five runs, and the run with means. More rows are added to these.
TEST_F(Ensemble, SobolsIndicesComeFromRowsOfRuns) {
  const auto sobol = [&](const std::string& rows) {
    return finish(start({QUOIN_PROGRAM, "sensitivity", study_, "--out", (folder_ / "s").string(), "--sobol", rows,
                         "--set", "stage.shear.displacement=0.00005"}));
  };
  ASSERT_EQ(sobol("8"), 0) << error_;
  EXPECT_EQ(finished("s"), 8 * 5 + 1);
  EXPECT_THAT(out_, HasSubstr("joints.mortar.cohesion"));
  const auto lines = lines_of(read_all(folder_ / "s" / "sobol.csv"));
  EXPECT_EQ(lines[0], "input,output,rows,first,first_low,first_high,total,total_low,total_high");
  EXPECT_THAT(lines[1], testing::StartsWith("\"pressure\",peak_force_N,8,"));
  ASSERT_EQ(sobol("9"), 0) << error_;
  EXPECT_EQ(finished("s"), 9 * 5 + 1);
  EXPECT_EQ(sobol("7"), 2);
}

// Without --sobol each of three inputs is decreased and increased alone; one run has all means.
TEST_F(Ensemble, SensitivityOneAtATimeIsTwoRunsAnInput) {
  ASSERT_EQ(finish(start({QUOIN_PROGRAM, "sensitivity", study_, "--out", (folder_ / "s").string(), "--no-pictures",
                          "--set", "stage.shear.displacement=0.00005"})),
            0)
      << error_;
  EXPECT_THAT(error_, HasSubstr("correlation is left out")) << "it was so in silence";
  EXPECT_EQ(finished("s"), 2 * 3 + 1);
  EXPECT_THAT(out_, HasSubstr("joints.mortar.cohesion"));
  EXPECT_TRUE(fs::exists(folder_ / "s" / "sensitivity.csv"));
  // The pressure, uniform from 0.2 to 0.4 MPa, is at its 16 % and 84 % quantiles once, else at its mean.
  std::map<long, int> pressures;  // in N/m2, number of runs
  for (const auto& file : fs::recursive_directory_iterator(folder_ / "s")) {
    if (file.path().filename() != "sample.json") continue;
    ++pressures[std::lround(nlohmann::json::parse(read_all(file))["inputs"]["pressure"].get<double>())];
  }
  EXPECT_EQ(pressures, (std::map<long, int>{{231731, 1}, {300000, 5}, {368269, 1}}));
}

// Properties that scatter in the scene itself are inputs, as those below [set]. They were left out.
TEST_F(Ensemble, SensitivityHasWhatScattersInTheScene) {
  std::string scene = read_all(QUOIN_ENSEMBLE_TESTS "/../cli/small_wall.toml");
  const std::size_t at = scene.find("tensile_strength"), end = scene.find('\n', at);
  scene.replace(at, end - at, "tensile_strength = { distribution = \"lognormal\", mean = 0.2e6, cov = 0.3 }");
  std::ofstream(folder_ / "scene.toml") << scene;
  std::ofstream(folder_ / "study.toml") << "title = \"s\"\nscene = \"scene.toml\"\nsamples = 2\n";
  ASSERT_EQ(finish(start({QUOIN_PROGRAM, "sensitivity", (folder_ / "study.toml").string(), "--out",
                          (folder_ / "s").string(), "--no-pictures", "--set", "stage.shear.displacement=0.00005"})),
            0)
      << error_;
  EXPECT_THAT(out_, HasSubstr("joints.mortar.tensile_strength"));
  EXPECT_EQ(finished("s"), 3);
}

// A name with a dot is in quotes in keys of --set, below [set] and for what scatters in the scene.
TEST_F(Ensemble, JointsMayHaveNamesWithADot) {
  std::string scene = read_all(QUOIN_ENSEMBLE_TESTS "/../cli/small_wall.toml");
  for (std::size_t at = scene.find("mortar"); at != std::string::npos; at = scene.find("mortar", at + 8)) {
    const bool header = scene[at - 1] == '.';
    scene.replace(at, 6, header ? "\"mortar.1\"" : "mortar.1");
  }
  const std::size_t at = scene.find("tensile_strength"), end = scene.find('\n', at);
  scene.replace(at, end - at, "tensile_strength = { distribution = \"lognormal\", mean = 0.2e6, cov = 0.3 }");
  std::ofstream(folder_ / "scene.toml") << scene;
  std::ofstream(folder_ / "study.toml") << "title = \"s\"\nscene = \"scene.toml\"\nsamples = 2\n"
                                           "[set.joints.\"mortar.1\"]\nfriction_angle = 31.0\n";
  ASSERT_EQ(finish(start({QUOIN_PROGRAM, "sensitivity", (folder_ / "study.toml").string(), "--out",
                          (folder_ / "s").string(), "--no-pictures", "--set", "stage.shear.displacement=0.00005"})),
            0)
      << error_;
  EXPECT_THAT(out_, HasSubstr("joints.\"mortar.1\".tensile_strength"));
  EXPECT_EQ(finished("s"), 3);
}

// A cube on springs of kn A = 1 GN/m is pressed down: the force over its displacement is linear. Bands were those of
// the horizontal displacement, which is 0, and so empty.
TEST_F(Ensemble, BandsOfAVerticalTestAreVertical) {
  std::ofstream(folder_ / "cube.toml") << dry_stone(30) << kCubeOnGround << kPressedCube << R"([output]
monitor = "cube"
frames = 0
plots = false
)";
  std::ofstream(folder_ / "study.toml") << "scene = \"cube.toml\"\nsamples = 2\n" << kVariedDensity;
  ASSERT_EQ(written_study("a", {"--no-pictures", "--jobs", "1"}), 0) << error_;
  const auto bands = lines_of(read_all(folder_ / "a" / "curve_bands.csv"));
  ASSERT_EQ(bands.size(), 202u);
  double displacement = 0.0, force = 0.0;
  ASSERT_EQ(std::sscanf(bands.back().c_str(), "%lf,%lf", &displacement, &force), 2);
  EXPECT_GT(displacement, 1e-4);
  EXPECT_NEAR(force, 1e9 * displacement, 0.02 * 1e9 * displacement);
}

// A wall that is pushed towards -x has bands of positive forces, between those of its weakest and its strongest sample.
// Forces had kept their sign, so that q05 was the strongest wall. In cycles the bands are of one side, whichever is
// first.
TEST_F(Ensemble, BandsOfAPushTowardsMinusXAreThoseOfItsForces) {
  const std::string cycles =
      "[{name='precompression',kind='pressure',pressure=0.3e6},{name='shear',kind='cycles',"
      "velocity=-0.2,amplitudes=[0.05e-3,0.1e-3]}]";
  for (const std::string& set : {std::string("stage.shear.velocity=-0.2"), "stage=" + cycles}) {
    const std::string out = set.substr(0, 7);
    ASSERT_EQ(ensemble(out, {"--samples", "3", "--jobs", "1", "--set", set}), 0) << error_;
    const auto bands = lines_of(read_all(folder_ / out / "curve_bands.csv"));
    ASSERT_EQ(bands.size(), 202u);
    double u = 0.0, mean = 0.0, of_means = 0.0, q05 = 0.0, q95 = 0.0, most = 0.0;
    for (std::size_t i = 1; i < bands.size(); ++i) {
      ASSERT_EQ(std::sscanf(bands[i].c_str(), "%lf,%lf,%lf,%lf,%*f,%*f,%*f,%lf", &u, &mean, &of_means, &q05, &q95), 5);
      EXPECT_TRUE(q05 <= mean && mean <= q95) << bands[i];
      most = std::max(most, q95);
    }
    const auto summary = nlohmann::json::parse(read_all(folder_ / out / "summary.json"));
    const double peak = summary["outputs"]["peak_force_N"]["mean"];
    EXPECT_NEAR(most, peak, 0.3 * peak) << "of three samples the largest is near their mean";
    EXPECT_GT(mean, 0.5 * peak);
  }
}

// Joints of a wall along z have their places along z, and the picture is drawn along it.
TEST_F(Ensemble, CracksOfAWallAlongZAreDrawnAlongIt) {
  std::ofstream(folder_ / "wall.toml") << dry_stone(30) << R"([[block]]
name = "ground"
material = "stone"
fixed = true
box = { lower = [-1, -0.2, -1], size = [2, 0.2, 4] }
[[dry_wall]]
material = "stone"
courses = 2
units_per_course = 3
unit = [0.4, 0.2, 0.2]
direction = 90
[[stage]]
gravity = [0, -9.81, 0]
duration = 0.02
[output]
frames = 0
plots = false
)";
  std::ofstream(folder_ / "study.toml") << "scene = \"wall.toml\"\nsamples = 1\n" << kVariedDensity;
  ASSERT_EQ(written_study("a", {"--jobs", "1"}), 0) << error_;
  const auto joints = lines_of(read_all(folder_ / "a" / "crack_probability.csv"));
  EXPECT_EQ(joints.at(0), "block_a,block_b,x0_m,y0_m,x1_m,y1_m,probability,z0_m,z1_m");
  double first = 1.0, last = 0.0;
  for (std::size_t i = 1; i < joints.size(); ++i) {
    double x0, y0, x1, y1, probability, z0, z1;
    ASSERT_EQ(std::sscanf(joints[i].c_str(), "%*d,%*d,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &x0, &y0, &x1, &y1, &probability,
                          &z0, &z1),
              7);
    first = std::min(first, z0), last = std::max(last, z1);
  }
  EXPECT_NEAR(first, 0.0, 1e-6);
  EXPECT_NEAR(last, 1.2, 1e-6) << "3 units of 0.4 m";
  double low = 1.0, high = 0.0;
  for (const std::string& line : lines_of(read_all(folder_ / "a" / "plots" / "crack_probability.dat"))) {
    double along = 0.0;
    if (std::sscanf(line.c_str(), "%lf", &along) == 1) low = std::min(low, along), high = std::max(high, along);
  }
  EXPECT_NEAR(high - low, 1.2, 1e-6);
}

// One input at a time, with given results in place of runs. The pressure is uniform from 0.2 to 0.4 MPa, the strength
// lognormal with mean 0.2 MPa and a coefficient of variation of 0.3.
TEST_F(Ensemble, SensitivityIsThatOfTheTrials) {
  quoin::ensemble::Study study = quoin::ensemble::read_study(study_);
  study.trials = quoin::ensemble::Trials::one_at_a_time;
  const quoin::ensemble::StudyFolder folder(folder_ / "s", study, {}, {study_, {}});
  const auto give = [&](int number, const char* status, double peak) {
    fs::create_directories(folder.sample(std::uint64_t(number)));
    std::ofstream(folder.sample(std::uint64_t(number)) / "sample.json") << nlohmann::json{
        {"status", status}, {"inputs", nlohmann::json::object()}, {"outputs", {{"peak_force_N", peak}}}};
  };
  ASSERT_EQ(study.inputs().size(), 3u);
  give(0, "done", 50.0);
  give(1, "done", 44.0), give(2, "done", 54.0);
  for (int k = 1; k < 3; ++k) {
    if (study.inputs()[std::size_t(k)].name == "joints.mortar.cohesion")
      give(2 * k + 1, "failed", 1.0), give(2 * k + 2, "done", 99.0);
    else
      give(2 * k + 1, "done", 51.0), give(2 * k + 2, "done", 48.0);
  }
  const std::string words = quoin::ensemble::write_sensitivity(folder, study, false);

  std::map<std::string, std::vector<std::string>> rows;
  for (const std::string& line : lines_of(read_all(folder_ / "s" / "sensitivity.csv"))) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
    rows[cells.at(0)] = cells;
  }
  ASSERT_EQ(rows.size(), 4u) << "a head and three inputs of one output";
  const auto expect = [&](const char* input, const std::vector<double>& values) {
    const auto& cells = rows["\"" + std::string(input) + "\""];
    ASSERT_EQ(cells.size(), 11u) << input;
    EXPECT_EQ(cells[1], "peak_force_N");
    for (std::size_t i = 0; i < values.size(); ++i)
      EXPECT_NEAR(std::stod(cells[2 + i]), values[i], 1e-9 * std::abs(values[i]) + 1e-12)
          << input << ", " << rows["input"][2 + i];
  };
  const double quantile = 0.5 * std::erfc(-1.0 / std::sqrt(2.0)),
               half = 0.2e6 * (quantile - 0.5);  // of a normal + 1 sd
  const double all = 5.0 * 5.0 + 1.5 * 1.5;
  expect("pressure",
         {0.3e6 - half, 0.3e6, 0.3e6 + half, 44, 50, 54, 10.0 / 50.0 * 0.3e6 / (2 * half), 25.0 / all, 0.1});
  const double sigma = std::sqrt(std::log(1.09)), median = 0.2e6 / std::sqrt(1.09);
  const double low = median * std::exp(-sigma), high = median * std::exp(sigma);
  const double straight = 51 - 3 * (0.2e6 - low) / (high - low);
  expect("joints.mortar.tensile_strength",
         {low, 0.2e6, high, 51, 50, 48, -3.0 / 50.0 * 0.2e6 / (high - low), 2.25 / all, std::abs(50 - straight) / 3});
  EXPECT_EQ(rows["\"joints.mortar.cohesion\""][5], "") << "of a sample that failed";

  // In the text the largest influence is first, and unknown ones are last.
  const auto lines = lines_of(words);
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_THAT(lines[0], testing::StartsWith("peak_force_N"));
  EXPECT_THAT(lines[1],
              AllOf(testing::StartsWith("pressure "), HasSubstr(" 44 "), HasSubstr(" 54 "), HasSubstr("91.7 %")));
  EXPECT_THAT(lines[2], AllOf(testing::StartsWith("joints.mortar.tensile_strength "), HasSubstr("8.3 %")));
  EXPECT_THAT(lines[3], testing::StartsWith("joints.mortar.cohesion "));
}

TEST_F(Ensemble, RecordsSamplesThatFailAndGoesOn) {
  // A pressure that may be negative is refused by the reader of the scene.
  std::ofstream(folder_ / "study.toml")
      << "scene = \"" << small_ << "\"\nsamples = 8\n"
      << "[set.stage.shear]\nvelocity = 0.2\ndisplacement = 0.0001\n"
      << "[[quantity]]\nkey = \"stage.precompression.pressure\"\ndistribution = \"normal\"\nmean = 0.1e6\nsd = 0.2e6\n";
  ASSERT_EQ(written_study("f", {"--no-pictures"}), 0) << error_;
  const auto lines = lines_of(table("f"));
  ASSERT_EQ(lines.size(), 9u);
  int failed = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (lines[i].find(",failed,") == std::string::npos) continue;
    ++failed;
    EXPECT_THAT(lines[i], HasSubstr("pressure"));
    EXPECT_THAT(lines[i], testing::Not(HasSubstr(QUOIN_CLI_TESTS)));  // without paths of this machine
  }
  EXPECT_GT(failed, 0);
  EXPECT_LT(failed, 8);
  EXPECT_THAT(out_, HasSubstr(fmt::format("{} of them failed", failed)));
}

// Thirty-two processes, started at the same time.
TEST_F(Ensemble, ThirtyTwoProcessesShareAFolder) {
  ASSERT_EQ(ensemble("alone", {"--samples", "40", "--jobs", "2"}), 0) << error_;
  std::vector<pid_t> children;
  for (int i = 0; i < 32; ++i) children.push_back(start(words("shared", {"--samples", "40", "--jobs", "1"})));
  for (const pid_t child : children) EXPECT_EQ(finish(child), 0);
  EXPECT_EQ(table("shared"), table("alone"));
  // The process that computes a sample writes its name into the claim, once.
  for (int i = 0; i <= 40; ++i) {
    const std::string claim = read_all(folder_ / "shared" / "claims" / fmt::format("{:06}", i));
    EXPECT_EQ(lines_of(claim).size(), 1u) << i << ": " << claim;
  }
}

TEST_F(Ensemble, DiesAsAWholeAndGoesOnToTheSameTable) {
  ASSERT_EQ(ensemble("whole", {"--samples", "60", "--jobs", "2"}), 0) << error_;
  const pid_t driver = start(words("killed", {"--samples", "60", "--jobs", "2"}));
  wait_until_finished("killed", 5);
  kill(driver, SIGKILL);
  EXPECT_EQ(finish(driver), 128 + SIGKILL);
  for (int i = 0; i < 200 && !processes("killed").empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(processes("killed").empty());  // its workers have ended, too
  const int kept = finished("killed");
  EXPECT_GE(kept, 5);
  EXPECT_LT(kept, 61);

  // Then one worker is killed; the driver computes its sample again.
  const pid_t second = start(words("killed", {"--samples", "60", "--jobs", "1"}));
  bool killed = false;
  for (int i = 0; i < 1000 && !killed; ++i) {
    for (const pid_t process : processes("killed"))
      killed = killed || (process != second && kill(process, SIGKILL) == 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_TRUE(killed);
  EXPECT_EQ(finish(second), 0) << error_;
  EXPECT_EQ(table("killed"), table("whole"));
}

TEST_F(Ensemble, CtrlCKeepsWhatIsFinished) {
  const pid_t driver = start(words("a", {"--samples", "200", "--jobs", "2"}));
  wait_until_finished("a", 3);
  kill(driver, SIGINT);
  EXPECT_EQ(finish(driver), 130);
  EXPECT_THAT(error_, HasSubstr("samples"));
  EXPECT_EQ(ensemble("a", {"--samples", "200", "--gather"}), 0) << error_;
  EXPECT_GE(lines_of(table("a")).size(), 3u);
}

// A scene, its law and its study are read once. Changes of the files during the study, and before other processes join
// it, have no effect. The files are changed in place, as by editors and compilers.
TEST_F(Ensemble, ReadsAllThatItIsComputedFromOnce) {
  const std::string scene = read_all(small_), law = read_all(QUOIN_LAWS "/fracture_energy.so");
  const fs::path scene_file = folder_ / "wall.toml", law_file = folder_ / "law.so", study_file = folder_ / "study.toml";
  const auto write = [](const fs::path& file, const std::string& text) { std::ofstream(file) << text; };
  const auto with = [](std::string text, const std::string& there, const std::string& here) {
    return text.replace(text.find(there), there.size(), here);
  };
  const std::string of_file = with(scene, "\"fracture_energy\"", "\"" + law_file.string() + "\"");
  const std::string study = with(read_all(study_), "../cli/small_wall.toml", "wall.toml");
  write(scene_file, of_file), write(law_file, law), write(study_file, study);
  const auto command = [&](const std::string& out, const char* samples, const std::string& what) {
    return start({QUOIN_PROGRAM, "ensemble", what, "--out", (folder_ / out).string(), "--no-pictures", "--jobs", "1",
                  "--samples", samples});
  };
  ASSERT_EQ(finish(command("whole", "12", study_file.string())), 0) << error_;

  const pid_t driver = command("edited", "8", study_file.string());
  wait_until_finished("edited", 1);
  write(scene_file, with(of_file, "friction_angle = 35.0", "friction_angle = 20.0"));
  write(law_file, read_all(QUOIN_LAWS "/elastic.so"));
  write(study_file, with(study, "mean = 0.3e6", "mean = 0.1e6"));
  ASSERT_EQ(finish(driver), 0) << error_;
  const std::string whole = table("whole");
  EXPECT_THAT(whole, testing::StartsWith(table("edited")));
  EXPECT_EQ(lines_of(table("edited")).size(), 9u);

  // The changed file is another study; the first one is continued from its folder.
  EXPECT_EQ(finish(command("edited", "12", study_file.string())), 3);
  write(law_file, law), write(study_file, study);
  EXPECT_EQ(finish(command("edited", "12", study_file.string())), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("(different: text of the scene)"), HasSubstr("in place of the study")));
  write(law_file, read_all(QUOIN_LAWS "/elastic.so")), fs::remove(scene_file), fs::remove(study_file);
  ASSERT_EQ(finish(command("edited", "12", (folder_ / "edited").string())), 0) << error_;
  EXPECT_EQ(table("edited"), whole);
  EXPECT_EQ(finish(command("whole", "12", (folder_ / "edited").string())), 2) << "two folders";

  const fs::path kept = folder_ / "edited" / "inputs";
  for (const auto& entry : fs::directory_iterator(kept)) {
    if (entry.path().filename().string().ends_with("wall.toml")) write(entry.path(), scene);
  }
  EXPECT_EQ(finish(command("edited", "12", (folder_ / "edited").string())), 3);
  EXPECT_THAT(error_, HasSubstr("wall.toml is not what was kept then"));
}

// A mesh of the scene is read once, too: it is removed after the first sample. A cube falls on another one.
TEST_F(Ensemble, ReadsMeshesOnce) {
  std::ofstream(folder_ / "cube.off") << "OFF\n8 6 0\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 0 1\n1 0 1\n0 1 1\n1 1 1\n"
                                         "4 0 4 6 2\n4 1 3 7 5\n4 0 1 5 4\n4 2 6 7 3\n4 0 2 3 1\n4 4 5 7 6\n";
  std::ofstream(folder_ / "blocks.toml") << R"(
[materials.stone]
density = 1000.0
young_modulus = 1e10
poisson_ratio = 0.2
[joints.dry]
law = "coulomb_slip"
initial_state = "dry"
normal_stiffness = 1e8
shear_stiffness = 1e8
friction_angle = 35.0
[[block]]
name = "base"
material = "stone"
fixed = true
box = { lower = [0, -1, 0], size = [1, 1, 1] }
[[block]]
name = "cube"
material = "stone"
mesh = "cube.off"
[[stage]]
name = "weight"
gravity = [0, -9.81, 0]
duration = 0.2
)";
  std::ofstream(folder_ / "study.toml")
      << "scene = \"blocks.toml\"\nsamples = 6\n[[quantity]]\nname = \"density\"\nkey = "
         "\"materials.stone.density\"\ndistribution = \"uniform\"\nlower = 900\n"
         "upper = 1100\n";
  const pid_t driver = start({QUOIN_PROGRAM, "ensemble", (folder_ / "study.toml").string(), "--out",
                              (folder_ / "m").string(), "--no-pictures", "--jobs", "1"});
  wait_until_finished("m", 1);
  fs::remove(folder_ / "cube.off");
  ASSERT_EQ(finish(driver), 0) << error_;
  EXPECT_THAT(out_, HasSubstr("6 of 6 samples finished, 0 of them failed"));
}

// On a full disk, with files limited to 2 kB after the start, the study ends with the reason.
TEST_F(Ensemble, EndsWhereTheDiskIsFull) {
  ASSERT_EQ(ensemble("a", {"--samples", "1"}), 0) << error_;
  const pid_t driver = start(words("a", {"--samples", "20", "--jobs", "2"}), -1, [] {
    alarm(60);  // ends a process that does not end itself
    const rlimit limit{2000, 2000};
    setrlimit(RLIMIT_FSIZE, &limit);
  });
  EXPECT_EQ(finish(driver), 3) << error_;
  EXPECT_THAT(error_, testing::ContainsRegex("sample [0-9]+ could not be computed: .*history.csv.*cannot be written"));
  EXPECT_EQ(finished("a"), 2);
  ASSERT_EQ(ensemble("a", {"--samples", "3"}), 0) << error_;  // without the limit
  EXPECT_EQ(lines_of(table("a")).size(), 4u);
}

// A study fails if all its samples fail: no equilibrium within ten steps.
TEST_F(Ensemble, FailsWhereAllSamplesFail) {
  const std::vector<std::string> more{"--samples", "2", "--set", "stage.precompression.max_steps=10"};
  EXPECT_EQ(ensemble("a", more), 5);
  EXPECT_THAT(error_, AllOf(HasSubstr("all samples failed, 2 of 2 until now; sample 1: "), HasSubstr("10 steps")));
  EXPECT_THAT(out_, HasSubstr("2 of 2 samples finished, 2 of them failed"));
  EXPECT_EQ(lines_of(table("a")).size(), 3u) << "the table is written all the same";
  EXPECT_EQ(ensemble("a", {"--samples", "2", "--set", "stage.precompression.max_steps=10", "--gather"}), 5);
  for (const std::vector<std::string>& trials : {std::vector<std::string>{}, {"--sobol", "8"}}) {
    std::vector<std::string> all{QUOIN_PROGRAM,
                                 "sensitivity",
                                 study_,
                                 "--out",
                                 (folder_ / "s").string(),
                                 "--no-pictures",
                                 "--set",
                                 "stage.precompression.max_steps=10"};
    all.insert(all.end(), trials.begin(), trials.end());
    EXPECT_EQ(finish(start(all)), 5) << error_;
    EXPECT_THAT(error_, HasSubstr("all samples failed"));
    fs::remove_all(folder_ / "s");
  }
}

// Settings of results only are checked before the runs, and may be changed after them.
TEST_F(Ensemble, FragilitiesOfNoColumnAreRefusedBeforeTheWork) {
  const auto write = [&](const std::string& output) {
    std::string text = read_all(study_);
    const std::string scene = "../cli/small_wall.toml";
    text.replace(text.find(scene), scene.size(), small_);
    std::ofstream(folder_ / "study.toml") << text << "\n[[fragility]]\noutput = \"" << output << "\"\n";
  };
  const auto run = [&] { return written_study("a", {"--no-pictures", "--samples", "3"}); };
  write("peak_force_kN");
  EXPECT_EQ(run(), 3);
  EXPECT_THAT(error_, AllOf(HasSubstr("study.toml:"),
                            HasSubstr("fragility.1.output = \"peak_force_kN\": samples.csv has "
                                      "no such column, did you mean 'peak_force_N'?"),
                            HasSubstr("joints.mortar.cohesion_least")));
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  for (const char* output : {"peak_force_N", "work_J", "joints.mortar.cohesion_least", "pressure"}) {
    write(output);
    EXPECT_EQ(run(), 0) << error_;
    EXPECT_THAT(error_, testing::Not(HasSubstr("no such column")));
    const auto results = nlohmann::json::parse(read_all(folder_ / "a" / "summary.json"));
    EXPECT_EQ(results["fragility"][0]["output"], output);
    EXPECT_EQ(results["fragility"][0]["reached"], 3);
  }
}

// Calls of Slurm's programs, and their outputs. Stand-ins start the workers here; slurm_test.py uses Slurm where it is
// installed.
TEST_F(Ensemble, AsksSlurmForWorkersAndWaitsForThem) {
  const auto stand_in = [&](const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << "#!/bin/sh\nfolder=" << folder_.string() << "\n" << text;
    fs::permissions(folder_ / name, fs::perms::owner_all);
  };
  const std::string task =
      "while [ \"${1%/slurm.sh}\" = \"$1\" ]; do shift; done\n(/bin/sleep 0.5; /bin/sh \"$@\") >/dev/null 2>&1 &\n";
  const auto ask = [&](const std::string& out, std::vector<std::string> more) {
    more.insert(more.begin(), {"--slurm", "--tasks", "2", "--samples", "3"});
    return finish(start(words(out, more), -1, [&] { setenv("PATH", folder_.c_str(), 1); }));
  };
  EXPECT_EQ(ask("a", {}), 3);
  EXPECT_THAT(error_, HasSubstr("sbatch: No such file or directory; --slurm needs the programs of Slurm"));

  stand_in("sbatch", "echo no such partition; exit 1\n");
  EXPECT_EQ(ask("a", {}), 3);
  EXPECT_THAT(error_, HasSubstr("sbatch refused the job: no such partition"));

  // Workers that end before they have computed a sample.
  stand_in("sbatch", "echo a warning; echo '17;far'\n");
  stand_in("squeue", "echo 'slurm_load_jobs error: Invalid job id specified'; exit 1\n");
  EXPECT_EQ(ask("a", {}), 5);
  EXPECT_THAT(error_, HasSubstr("3 samples are missing, as their workers have ended"));

  stand_in("sbatch", "echo \"$@\" > $folder/asked\n" + task + "echo 17\n");
  stand_in("squeue", "echo \"$@\" > $folder/queued; echo 17_1\n");
  ASSERT_EQ(ensemble("b", {"--samples", "1"}), 0) << error_;  // sample 1 and that of the means
  EXPECT_EQ(ask("b", {}), 0) << error_;
  EXPECT_THAT(error_, testing::AllOf(HasSubstr("job 17 of Slurm: 2 workers; results, also before the end: "),
                                     HasSubstr(" --samples 3 --gather"), HasSubstr("2/4 samples")));
  EXPECT_THAT(read_all(folder_ / "asked"), HasSubstr(" ensemble " + (folder_ / "b").string() + " --samples 3 "))
      << "of what is kept there";
  EXPECT_THAT(out_, HasSubstr("3 of 3 samples finished, 0 of them failed"));
  EXPECT_THAT(read_all(folder_ / "asked"), HasSubstr(" --array=1-2 --ntasks=1 "));
  EXPECT_THAT(read_all(folder_ / "queued"), HasSubstr("--jobs=17 "));
  ASSERT_EQ(ensemble("here", {"--samples", "3"}), 0) << error_;
  EXPECT_EQ(table("b"), table("here"));

  EXPECT_EQ(ask("c", {"--detach"}), 0) << error_;
  EXPECT_EQ(out_, "");
  wait_until_finished("c", 4);
  EXPECT_EQ(finished("c"), 4);
}

TEST_F(Ensemble, RefusesTheFolderOfAnotherStudy) {
  ASSERT_EQ(ensemble("a", {"--samples", "1"}), 0) << error_;
  EXPECT_EQ(ensemble("a", {"--samples", "1", "--set", "output.energy=true"}), 3);
  EXPECT_THAT(error_, HasSubstr("keys set"));
  EXPECT_THAT(error_, HasSubstr("--out"));
}

// Settings that are given twice are refused, since one of them would have no effect.
// The study wrote over the summary of the run.
TEST_F(Ensemble, RefusesTheFolderOfARun) {
  fs::create_directories(folder_ / "run");
  std::ofstream(folder_ / "run" / ".quoin-manifest") << "results of quoin, partial files .0\n";
  EXPECT_EQ(ensemble("run"), 3);
  EXPECT_THAT(error_, HasSubstr("has the results of a run"));
  EXPECT_FALSE(fs::exists(folder_ / "run" / "samples"));
}

TEST_F(Ensemble, NothingOfAStudyIsLeftOutInSilence) {
  const auto run = [&](const std::string& quantity, const std::vector<std::string>& more = {}) {
    std::string text = read_all(study_);
    const std::string scene = "../cli/small_wall.toml";
    text.replace(text.find(scene), scene.size(), small_);
    std::ofstream(folder_ / "study.toml") << text << quantity;
    std::vector<std::string> all{"--samples", "1"};
    all.insert(all.end(), more.begin(), more.end());
    return written_study("a", all);
  };
  const auto quantity = [](const std::string& name, const std::string& key) {
    return "[[quantity]]\nname = \"" + name + "\"\nkey = \"" + key +
           "\"\ndistribution = \"uniform\"\nlower = 9e9\nupper = 10e9\n";
  };
  const std::string modulus = "materials.brick.young_modulus";
  for (const char* name : {"pressure", "peak_force_N", "joints.mortar.cohesion_mean"}) {
    EXPECT_EQ(run(quantity(name, modulus)), 3);
    EXPECT_THAT(error_, HasSubstr("study.toml: quantity.2: samples.csv has two columns called \"" + std::string(name)));
  }
  EXPECT_EQ(run(quantity("E", modulus) + quantity("F", modulus)), 3);
  EXPECT_THAT(error_, HasSubstr("quantity.3.key = \"" + modulus + "\": two quantities of one key"));
  EXPECT_EQ(run(quantity("velocity", "stage.shear.velocity")), 3);
  EXPECT_THAT(error_, HasSubstr("is set too (stage.shear.velocity=0.2)"));
  EXPECT_EQ(run("", {"--set", "stage.precompression.pressure=0.3e6"}), 3);
  EXPECT_THAT(error_, HasSubstr("quantity.1.key = \"stage.precompression.pressure\": is set too"));
  EXPECT_EQ(run("", {"--set", "random.seed=7"}), 3);
  EXPECT_THAT(error_, HasSubstr("random.seed=7: samples of a study are numbered"));
  EXPECT_FALSE(fs::exists(folder_ / "a"));
}

TEST_F(Ensemble, NamesTheFaultsOfAStudy) {
  std::ofstream(folder_ / "study.toml")
      << "scene = \"none.toml\"\nsample = 3\nmethod = \"sobol\"\n[[quantity]]\nkey = \"a\"\n";
  EXPECT_EQ(written_study("a"), 3);
  EXPECT_THAT(error_, HasSubstr("study.toml:2: sample = 3: unknown key, did you mean 'samples'?"));
  EXPECT_THAT(error_, HasSubstr("quantity.1.distribution: missing"));
}

}  // namespace
