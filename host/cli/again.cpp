#include "cli/again.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "base/error.h"
#include "files/notice.h"

namespace quoin {

namespace fs = std::filesystem;

namespace {

// First difference of two histories: "row 12, time_s: 0.25, there 0.5"; empty: none, or a file is missing.
std::string first_difference(const fs::path& here, const fs::path& there) {
  std::ifstream a(here), b(there);
  std::string header, line_a, line_b;
  if (!std::getline(a, header) || !std::getline(b, line_b)) return {};
  if (header != line_b) return "the columns";
  for (long row = 1;; ++row) {
    const bool more_a = static_cast<bool>(std::getline(a, line_a)), more_b = static_cast<bool>(std::getline(b, line_b));
    if (!more_a && !more_b) return {};
    if (more_a != more_b) return fmt::format("row {}, which only {} has", row, more_a ? "this run" : "that one");
    if (line_a == line_b) continue;
    std::istringstream names(header), values_a(line_a), values_b(line_b);
    std::string name, value_a, value_b;
    while (std::getline(names, name, ',') && std::getline(values_a, value_a, ',') &&
           std::getline(values_b, value_b, ',')) {
      if (value_a != value_b) return fmt::format("row {}, {}: {}, there {}", row, name, value_a, value_b);
    }
    return fmt::format("row {}", row);
  }
}

}  // namespace

SceneOptions options_of(const Provenance& there) {
  SceneOptions options;
  options.scene = there.scene;
  options.text = there.scene_text;
  options.law = there.request.law;
  options.overrides = there.request.overrides;
  std::error_code fault;
  fs::current_path(there.working_directory, fault);
  if (fault)
    notice(
        fmt::format("quoin: warning: the run was started in {}, which cannot be entered ({}): its paths count from "
                    "here",
                    there.working_directory, fault.message()));
  return options;
}

fs::path folder_again(const fs::path& folder) {
  fs::path whole = fs::absolute(folder).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // a trailing slash
  return whole += "-again";
}

void hold_against(const Provenance& here, const Provenance& there) {
  for (const HashedFile& file : here.inputs) {
    for (const HashedFile& then : there.inputs) {
      if (then.name == file.name && then.sha256 != file.sha256)
        throw Error(Exit::bad_input,
                    fmt::format("{}: has changed since that run: sha256 {}, then {}; bring the file of then back, or "
                                "run the scene itself",
                                file.name, file.sha256, then.sha256));
    }
  }
  for (const std::string& difference : differences(here, there)) notice("quoin: not as then: " + difference);
}

bool say_whether_same(const Provenance& here, const fs::path& folder_here, const Provenance& there,
                      const fs::path& folder_there) {
  const fs::path history = folder_there / "history.csv";
  std::error_code error;
  if (!there.history_sha256.empty() && fs::exists(history, error) &&
      sha256_of_file(history.string()) != there.history_sha256) {
    const std::string where = first_difference(folder_here / "history.csv", history);
    fmt::print("{} is not what its run wrote{}\n", history.string(), where.empty() ? "" : ": it differs at " + where);
    return false;
  }
  const bool same = here.state == there.state && here.history_sha256 == there.history_sha256;
  if (same) {
    fmt::print("the bits agree with {}: state {}, history.csv sha256 {:.16}\n", folder_there.string(), here.state,
               here.history_sha256);
    return true;
  }
  const std::string where = first_difference(folder_here / "history.csv", history);
  std::string why;
  for (const std::string& difference : differences(here, there)) why += (why.empty() ? "" : "; ") + difference;
  fmt::print(
      "the bits differ from {}: state {}, there {}; {}. {}\n", folder_there.string(), here.state, there.state,
      where.empty() ? "history.csv of the two tells no more" : "first at " + where,
      why.empty() ? "Program, laws, files and instruction set are the same: please report it" : "Not as then: " + why);
  return false;
}

}  // namespace quoin
