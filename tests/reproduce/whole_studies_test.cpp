// Complete texts of studies: runs with their overrides; for invented curves verdicts, tables, sentences and scripts of
// charts. studies_test.cpp compares single numbers with closed forms; this test checks words, labels, orders and
// constants. The texts are approved by people (approved/STUDY.txt, STUDY_brittle.txt, STUDY_reference.txt). Without
// simulations and gnuplot.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <tuple>

#include "../approved.h"
#include "reproduce/page.h"
#include "reproduce/study.h"
#include "reproduce/verdict_file.h"

namespace {

namespace fs = std::filesystem;
using namespace quoin::reproduce;

const quoin::Cycles kCycles{{0.002, 0.003}, {2, 1}, 0.01, 0.05, {}};

bool in_cycles(const RunSpec& spec) {
  for (const std::string& o : spec.overrides)
    if (o.starts_with("stage.cycles.")) return true;
  return spec.scene.starts_with("cyclic_");
}

// Behaviour of walls: slow softening, or an abrupt loss of nearly all strength, with large differences at the
// beginning.
enum class Walls { ductile, brittle, brittle_by_reference };

// Returns the quality of each: standard, fast, and reference, which has additional runs.
int quality_of(Walls walls) { return std::array{1, 0, 2}[static_cast<std::size_t>(walls)]; }
const char* suffix_of(Walls walls) { return std::array{"", "_brittle", "_reference"}[static_cast<std::size_t>(walls)]; }

// Returns the curve of a run, different for each run, so that an exchange is detected. number: index of the run in the
// study. Softening with a ripple after the peak, or a drop; in cycles an elastic-plastic spring.
Curve curve_of(int number, bool cycles, Walls walls) {
  Curve c;
  const bool brittle = walls != Walls::ductile;
  const double peak = brittle ? 61.0 - 1.9 * number : 40.0 + 3.7 * number, at = 0.9 + 0.13 * (number % 7),
               vertical = 95.0 + 11.0 * number, drop = at + 0.4 + 0.03 * number;
  const quoin::CyclicMotion motion(kCycles);
  double plastic = 0.0;
  const int rows = cycles ? 3000 : 1200;
  for (int i = 0; i <= rows; ++i) {
    double d = 0.005 * i, force = peak * d / at;
    int half_cycle = -1;
    if (cycles) {
      const double t = motion.duration() * i / rows, stiffness = 90.0 + number;
      d = 1e3 * motion.position(t), half_cycle = motion.half_cycle(t);
      force = stiffness * (d - plastic);
      if (std::abs(force) > peak)
        plastic = d - std::copysign(peak / stiffness, force), force = std::copysign(peak, force);
    } else if (d > at) {
      force = peak * (1.0 - 0.06 * (d - at)) + 0.4 * std::sin(9.0 * (d - at));
    }
    if (brittle && !cycles) {
      force += (3.0 + number) * std::exp(-d / 0.15) * std::min(1.0, d / 0.05);
      if (d > drop) force = std::max(4.0, force - 900.0 * (d - drop)) + 0.2 * std::sin(31.0 * d);
    }
    c.stage.push_back(2), c.half_cycle.push_back(half_cycle);
    c.displacement.push_back(d), c.force.push_back(force);
    c.vertical.push_back(vertical + 2.0 * d), c.unbalanced.push_back(1e-3 * (1.0 + number));
  }
  return c;
}

std::string in_words(const Study& study, const Quality& quality, const std::map<std::string, RunResult>& runs) {
  std::string text;
  for (const RunSpec& spec : study.runs(quality)) {
    text += fmt::format("run {}: {} law '{}' cost {:.3f}{}\n", spec.name, spec.scene, spec.law, spec.cost,
                        spec.may_fail ? " may fail" : "");
    for (const std::string& o : spec.overrides) text += "  " + o + "\n";
    const RunResult& r = runs.at(spec.name);
    if (r.cycles) text += "  in cycles\n";
  }
  return text;
}

std::string in_words(const StudyReport& report) {
  std::string text;
  for (const Verdict& v : report.verdicts)
    text += fmt::format("{} | {:.9g} of {} {} {} | {} | {}\n", v.claim, v.number,
                        v.reference ? fmt::format("{:.9g}", *v.reference) : "none", v.unit, kind_tag(v.kind),
                        v.reproduced ? "reproduced" : "not reproduced", v.text);
  for (const Picture& p : report.pictures) text += fmt::format("picture {}: {}\n", p.file.generic_string(), p.caption);
  for (const Table& t : report.tables) {
    text += fmt::format("table {}\n  {}\n", t.caption, fmt::join(t.header, " | "));
    for (const auto& row : t.rows) text += fmt::format("  {}\n", fmt::join(row, " | "));
  }
  for (const auto& [kind, sentences] : {std::pair{"agrees", &report.agrees},
                                        {"differs", &report.differs},
                                        {"seen", &report.seen},
                                        {"note", &report.notes},
                                        {"notice", &report.notices}})
    for (const std::string& s : *sentences) text += fmt::format("{}: {}\n", kind, s);
  return text;
}

// Returns whole scripts, and every 397th line of data, in which curves and columns differ.
std::string files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::string text;
  for (const fs::path& file : files) {
    std::ifstream stream(file);
    const bool data = file.extension() == ".dat" || file.extension() == ".csv";
    text += "file " + file.lexically_relative(folder).generic_string() + "\n";
    long i = 0;
    for (std::string line; std::getline(stream, line); ++i)
      if (!data || i % 397 == 0) text += "  " + line + "\n";
    if (data) text += fmt::format("  {} lines\n", i);
  }
  return text;
}

class WholeStudies : public ::testing::TestWithParam<std::tuple<std::string, Walls>> {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("quoin_whole_studies_" + std::to_string(getpid()));
    fs::create_directories(folder_);
    if (const char* path = std::getenv("PATH")) path_ = path;
    setenv("PATH", "/nonexistent", 1);  // without gnuplot the script of a chart is kept
  }
  void TearDown() override {
    setenv("PATH", path_.c_str(), 1);
    fs::remove_all(folder_);
  }
  fs::path folder_;
  std::string path_;
};

TEST_P(WholeStudies, SayWhatWasApproved) {
  const auto& [id, walls] = GetParam();
  const Study& study = *find_study(id);
  const Quality& quality = qualities().at(static_cast<std::size_t>(quality_of(walls)));
  std::map<std::string, RunResult> runs;
  for (const RunSpec& spec : study.runs(quality)) {
    const int number = static_cast<int>(runs.size());
    RunResult r;
    r.spec = spec, r.folder = folder_ / "runs" / fmt::format("{:02}", number), r.complete = true;
    if (in_cycles(spec)) r.cycles = kCycles;
    r.curve = curve_of(number, r.cycles.has_value(), walls);
    r.steps = 1000 + number, r.wall_clock = 60.0 + number;
    r.time_step = 0.6e-6 + 1e-8 * number, r.critical_time_step = 1e-6, r.bed_area = 0.099;
    r.blocks = 100 + number, r.beams = 2, r.zones = 1600 + number, r.points = 2000 + number;
    runs[spec.name] = r;
  }
  std::string text = fmt::format("{}: {}, {}\n{}\n", study.id, study.title, study.figures, study.claim);
  text += in_words(study, quality, runs);
  const StudyReport report = study.report(Findings(folder_, study.id, quality, runs));
  text += in_words(report);
  for (const Verdict& v : report.verdicts) text += verdict_line(study.id, v) + "\n";
  if (walls == Walls::ductile) {
    write_verdicts(verdict_file(folder_, study), study.id, report);
    write_section(folder_, study, quality, report);
    text += files_of(folder_);
  }
  for (std::size_t at; (at = text.find(folder_.string())) != std::string::npos;)
    text.replace(at, folder_.string().size(), "DIR");
  // The kernels of the law depend on the machine and have different rounding.
  quoin_test::expect_approved({fs::path(QUOIN_APPROVED) / (study.id + suffix_of(walls) + ".txt"), 1e-6}, text);
}

std::vector<std::string> ids() {
  std::vector<std::string> all;
  for (const Study& s : studies()) all.push_back(s.id);
  return all;
}
const auto name_of = [](const auto& of) { return std::get<0>(of.param) + suffix_of(std::get<1>(of.param)); };
INSTANTIATE_TEST_SUITE_P(All, WholeStudies,
                         ::testing::Combine(::testing::ValuesIn(ids()),
                                            ::testing::Values(Walls::ductile, Walls::brittle)),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Slow, WholeStudies,
                         ::testing::Combine(::testing::Values("brittle", "rate"),
                                            ::testing::Values(Walls::brittle_by_reference)),
                         name_of);

}  // namespace
