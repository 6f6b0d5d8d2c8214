#include "cli/resume.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <system_error>

#include "base/error.h"
#include "base/input_file.h"
#include "base/sha256.h"
#include "files/file.h"
#include "files/notice.h"

namespace quoin {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr const char* kRecord = "run.json";

Json read_json(const fs::path& path) { return Json::parse(read_input_file(path.string()), nullptr, false); }

}  // namespace

void write_run_record(const fs::path& folder, const RunOptions& options, const std::string& scene_text) {
  const Json json = {{"scene", options.scene.scene},
                     {"scene_sha256", sha256_of(scene_text)},
                     {"law", options.scene.law},
                     {"set", options.scene.overrides},
                     {"working_directory", fs::current_path().string()},
                     {"report", options.report},
                     {"svg", options.svg},
                     {"histories", options.histories},
                     {"compressed", options.compressed}};
  // A name that is not UTF-8 does not prevent the run; --resume just does not find it.
  write_file(folder / kRecord, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

void read_run_record(const fs::path& folder, RunOptions* options) {
  const fs::path path = folder / kRecord;
  std::error_code error;
  if (!fs::exists(path, error))
    throw Error(Exit::bad_input,
                fmt::format("{}: has no {}: no run was begun here; start it with quoin run SCENE.toml --out {}",
                            folder.string(), kRecord, folder.string()));
  const Json json = read_json(path);
  SceneOptions scene;
  scene.force = options->scene.force;
  fs::path place;
  try {
    scene.scene = json.at("scene").get<std::string>();
    scene.text_sha256 = json.at("scene_sha256").get<std::string>();
    scene.law = json.at("law").get<std::string>();
    scene.overrides = json.at("set").get<std::vector<std::string>>();
    place = json.at("working_directory").get<std::string>();
    for (const auto& [name, wanted] :
         {std::pair("report", &options->report), std::pair("svg", &options->svg),
          std::pair("histories", &options->histories), std::pair("compressed", &options->compressed)})
      *wanted = *wanted || json.value(name, false);
  } catch (const Json::exception&) {
    throw Error(Exit::bad_input,
                fmt::format("{}: is not the record of a run; start the run anew without --resume", path.string()));
  }
  fs::current_path(place, error);
  if (error)
    throw Error(Exit::bad_input,
                fmt::format("{}: the run was started in {}, where its paths count from, and that cannot be entered: {}",
                            path.string(), place.string(), error.message()));
  options->scene = std::move(scene);
}

bool is_done(const fs::path& folder) {
  const fs::path summary = folder / "summary.json";
  if (std::error_code error; !fs::exists(summary, error) || fs::exists(folder / "checkpoint.bin", error)) return false;
  const Json json = read_json(summary);
  return json.is_object() && json.value("status", Json()) == "done";
}

bool is_kept(const std::string& name, std::size_t frames) {
  if (name == kRecord || name == "checkpoint.bin") return true;
  for (std::size_t i = 0; i < frames; ++i) {
    for (const char* kind : {"blocks", "joints", "forces", "members"}) {
      const std::string frame = fmt::format("{}_{:04}", kind, i);
      if (name == frame + ".vtu" || name == frame + ".pvtu" || name.starts_with(frame + "_r")) return true;
    }
  }
  return false;
}

void say_what_is_missing(const fs::path& folder, std::size_t frames) {
  for (std::size_t i = 0; i < frames; ++i) {
    const fs::path frame = folder / fmt::format("blocks_{:04}.vtu", i);
    if (fs::exists(frame) || fs::exists(fs::path(frame).replace_extension("pvtu"))) continue;
    return notice(
        fmt::format("quoin: warning: {} is missing: frames from before the checkpoint are not written again, "
                    "and blocks.pvd lists them all the same",
                    frame.string()));
  }
}

}  // namespace quoin
