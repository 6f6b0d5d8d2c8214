// Complete outputs of commands against approved texts (approved/): help, checks of the shipped scenes, and short runs.
// The outputs of runs are messages, histories, summaries, scripts of pictures and arrays of frames. Other tests check
// single numbers. In these runs few joints crack, so that rounding is not amplified: the texts are those of AVX-512,
// and of AVX2 to 1e-5.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>

#include "../approved.h"
#include "program.h"
#include "results/read_vtu.h"

namespace {

using Words = std::vector<std::string>;

// Local damping depends on the sign of velocities, which at rest are only rounding. Kernels without fused multiply-add
// have another state at rest: displacements differ by 2e-5, and the unbalanced forces by 1 %.
bool fuses_here() {
#ifdef __x86_64__
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  return false;
#endif
}

class WholeOutput : public Cli {
 protected:
  void expect(const std::string& name, std::string text) const {
    for (const auto& [from, to] : {std::pair<std::string, std::string>{folder_.string(), "DIR"},
                                   {fs::path(QUOIN_PROGRAM).parent_path().string(), "BUILD"},
                                   {fs::path(QUOIN_TESTS).parent_path().string(), "SOURCE"}})
      for (std::size_t at; (at = text.find(from)) != std::string::npos;) text.replace(at, from.size(), to);
    // Replaces values that depend on the machine and the time.
    for (const auto& [pattern, to] : {std::pair{"of [0-9]+ MB here", "of # MB here"},
                                      {"computing time about .*", "computing time about #"},
                                      {"time: .*", "time: #"},
                                      {" in [0-9.]+ s;", " in # s;"},
                                      {"\\[[0-9]+/[0-9]+ [^\n]*steps/s[^\n]*\n", ""},
                                      {"threads, [A-Z0-9_]+", "threads, #"}})
      text = std::regex_replace(text, std::regex(pattern), to);
    quoin_test::expect_approved({fs::path(QUOIN_CLI_TESTS) / "approved" / (name + ".txt"), 1e-5, 1e-9}, text);
  }
  std::string said(const Words& words) {
    const int code = quoin(words);
    return fmt::format("quoin {}\n{}{}exit code {}\n", fmt::join(words, " "), out_, error_, code);
  }

  // Returns about 15 rows of a history.
  static std::string rows_of(const fs::path& file) {
    std::vector<std::string> lines;
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    std::string text;
    for (std::size_t i = 0; i < lines.size(); ++i)
      if (i == 0 || i + 1 == lines.size() || i % (lines.size() / 15 + 1) == 0) text += "  " + lines[i] + "\n";
    return text + fmt::format("  {} lines\n", lines.size());
  }
  template <class T>
  static std::string array_of(const quoin::VtuFile& file, const std::string& name) {
    const std::vector<T> values = file.values_of<T>(name);
    double largest = 0.0, sum = 0.0;
    for (const T v : values) largest = std::max(largest, std::abs(static_cast<double>(v)));
    for (const T v : values) sum += std::abs(static_cast<double>(v));
    // Values relative to the largest, so that negligible values are 0.
    std::string text = fmt::format("  {}: {} values, largest {:.6e}, mean", name, values.size(), largest);
    const double unit = largest > 0.0 ? largest : 1.0;
    text += fmt::format(" {:.5f};", values.empty() ? 0.0 : sum / unit / static_cast<double>(values.size()));
    for (std::size_t i = 0; i < values.size(); i += values.size() / 7 + 1)
      text += fmt::format(" {:.5f}", std::abs(static_cast<double>(values[i])) < 1e-6 * unit
                                         ? 0.0
                                         : static_cast<double>(values[i]) / unit);
    return text + "\n";
  }
  static std::string frame(const fs::path& path) {
    const quoin::VtuFile file(path);
    std::istringstream text(read_all(path));
    static const std::regex array(
        "<DataArray type=\"([A-Za-z0-9]+)\" Name=\"([^\"]+)\"(.*) format.*offset=\"[0-9]+\"(.*)/>");
    std::string all;
    for (std::string line; std::getline(text, line) && line.find("<AppendedData") == std::string::npos;) {
      std::smatch match;
      if (!std::regex_match(line, match, array)) {
        all += "  " + line + "\n";
        continue;
      }
      const std::string type = match[1], name = match[2];
      all += fmt::format("  {}{}{}\n", type, match[3].str(), match[4].str());
      all += type == "Float32" ? array_of<float>(file, name)
             : type == "Int32" ? array_of<std::int32_t>(file, name)
             : type == "Int64" ? array_of<std::int64_t>(file, name)
             : type == "UInt8" ? array_of<std::uint8_t>(file, name)
                               : "  not read: " + type + "\n";
    }
    return all;
  }
  // Returns the summary without values that depend on the machine and the time.
  static std::string summary_of(const fs::path& file) {
    auto json = nlohmann::ordered_json::parse(read_all(file));
    for (const char* key : {"wall_clock_s", "instruction_set", "version"}) json.erase(key);
    for (auto& law : json["laws"]) law.erase("version");
    auto& provenance = json["provenance"];
    for (const char* key : {"program", "machine", "laws", "instruction_set", "working_directory"})
      provenance.erase(key);
    for (const char* key : {"text", "sha256"}) provenance["scene"].erase(key);
    provenance.erase("results");
    return json.dump(1) + "\n";
  }
  std::string results() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(out()))
      if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::string text;
    for (const fs::path& file : files) {
      const std::string name = file.lexically_relative(out()).generic_string(), kind = file.extension().string();
      text += "file " + name + "\n";
      if (kind == ".vtu" && name.find("_0001") != std::string::npos) text += frame(file);
      if (kind == ".csv" || kind == ".dat") text += rows_of(file);
      if (kind == ".gp" || kind == ".pvd") text += read_all(file);
      if (name == "summary.json") text += summary_of(file);
    }
    return text;
  }
  void expect_run(const std::string& name, const std::string& scene, const Words& set) {
    if (!fuses_here()) GTEST_SKIP() << "the texts are those of kernels with fused multiply-add";
    Words words{"run", scene, "--out", out(), "--threads", "1"};
    for (const std::string& s : set) words.insert(words.end(), {"--set", s});
    std::string text = said(words);
    // Progress is shown only on a terminal.
    expect(name, text + results());
  }
};

TEST_F(WholeOutput, Help) {
  std::string text = said({"--help"});
  for (const char* command : {"run", "check", "models", "path", "fit", "reproduce", "report", "ensemble", "sensitivity",
                              "spectrum", "validate", "limit", "rest", "modes", "new", "completion"})
    text += said({command, "--help"});
  expect("help", text + said({"reproduce", "--list"}));
}

TEST_F(WholeOutput, Models) {
  std::string text;
  for (const char* law : {"elastic", "coulomb_slip", "fracture_energy", "cyclic_joint"}) text += said({"models", law});
  expect("models", text);
}

TEST_F(WholeOutput, ChecksOfScenes) {
  std::string text;
  for (const char* scene :
       {"arch", "cube_wall_10", "cyclic_isp1", "cyclic_wall_121", "damaged_wall_030", "ferris_tin_loi_1", "hollow_wall",
        "ispra_isp3", "mixed", "pavia_door", "solid_wall_030", "wall_2m_60"})
    text += said({"check", fmt::format("{}/{}.toml", QUOIN_SCENES, scene)});
  expect("checks", text);
}

TEST_F(WholeOutput, Paths) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(QUOIN_TESTS "/law/paths"))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  Words words{"path"};
  for (const fs::path& file : files) words.push_back(file.string());
  // The size of an error below its tolerance is rounding.
  expect("paths", std::regex_replace(said(words), std::regex("largest error [-+.0-9e]+"), "largest error #"));
}

TEST_F(WholeOutput, ShearedWall) { expect_run("wall", small_, {"stage.2.displacement=2e-5"}); }

TEST_F(WholeOutput, WallInCycles) {
  const std::string text = read_all(small_), scene = (folder_ / "cycles.toml").string();
  std::ofstream(scene)
      << text.substr(0, text.rfind("[[stage]]"))
      << "[[stage]]\nname = \"cycles\"\nkind = \"cycles\"\namplitudes = [1e-5, 2e-5]\n"
         "velocity = 0.002\nramp_time = 0.002\n[output]\nframes = 2\nframes_of = \"last\"\nenergy = true\n";
  expect_run("cycles", scene, {});
}

TEST_F(WholeOutput, BuildingWithFloors) {
  expect_run("building", QUOIN_TESTS "/host/small_building.toml",
             {"stage.push.displacement=1e-4", "output.frames=1", "output.frames_of=last"});
}

TEST_F(WholeOutput, WallPostAndArch) {
  expect_run("mixed", QUOIN_SCENES "/mixed.toml",
             {"stage.weight.duration=0.02", "stage.push.duration=0.02", "output.frames=1", "output.frames_of=last"});
}

}  // namespace
