#include "ensemble/kept_study.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/error.h"
#include "base/input_file.h"
#include "base/sha256.h"
#include "files/file.h"
#include "files/notice.h"

namespace quoin::ensemble {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr std::size_t kAnySize = std::numeric_limits<std::size_t>::max();

fs::path list_of(const fs::path& folder) { return folder / "inputs" / "inputs.json"; }

// Writes a file only where its bytes differ, as other processes may be reading it.
void write_if_new(const fs::path& file, const std::string& bytes) {
  std::error_code unknown;
  if (fs::exists(file, unknown) && read_input_file(file.string(), kAnySize) == bytes) return;
  write_file(file, bytes);
}

}  // namespace

void keep_study(const fs::path& folder, const StudyRequest& request) {
  make_folder(folder / "inputs");
  Json list{{"study", fs::absolute(request.study).lexically_normal().string()},
            {"set", request.overrides},
            {"working_directory", fs::current_path().string()},
            {"files", Json::array()}};
  for (const auto& [file, bytes] : kept_inputs().files()) {
    // Names contain the hash of the bytes, so that a list never refers to another version of a file.
    const std::string hash = sha256_of(bytes);
    const std::string name = fmt::format("{:.12}_{}", hash, fs::path(file).filename().string());
    write_if_new(folder / "inputs" / name, bytes);
    list["files"].push_back({{"file", file}, {"kept", name}, {"sha256", hash}});
  }
  write_if_new(list_of(folder), list.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

bool is_kept_study(const fs::path& folder) {
  std::error_code unknown;
  return fs::exists(list_of(folder), unknown);
}

StudyRequest take_kept_study(const fs::path& folder) {
  const std::string path = list_of(folder).string();
  const Json list = Json::parse(read_input_file(path), nullptr, false);
  const auto refuse = [&](const std::string& why) {
    throw Error(Exit::bad_input,
                fmt::format("{}: {}; give the file of the study, whose folder this is, with --out", path, why));
  };
  StudyRequest request;
  std::string place;
  try {
    request = {list.at("study").get<std::string>(), list.at("set").get<std::vector<std::string>>()};
    place = list.at("working_directory").get<std::string>();
    for (const Json& entry : list.at("files")) {
      const auto file = entry.at("file").get<std::string>(), name = entry.at("kept").get<std::string>();
      std::string bytes = read_input_file((folder / "inputs" / fs::path(name).filename()).string(), kAnySize);
      if (sha256_of(bytes) != entry.at("sha256").get<std::string>()) refuse(name + " is not what was kept then");
      kept_inputs().keep(file, std::move(bytes));
    }
  } catch (const Json::exception&) {
    refuse("is no list of what a study was read from");
  }
  std::error_code fault;
  fs::current_path(place, fault);
  if (fault)
    notice(
        fmt::format("quoin: warning: the study was begun in {}, which cannot be entered ({}): paths of laws count "
                    "from here",
                    place, fault.message()));
  return request;
}

}  // namespace quoin::ensemble
