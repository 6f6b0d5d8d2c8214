#include "results/provenance.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "base/input_file.h"
#include "base/sha256.h"
#include "files/memory.h"
#include "step/kernels.h"

#ifndef QUOIN_VERSION
#define QUOIN_VERSION "unknown"
#endif

namespace quoin {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// File of this code: the executable, or the Python module.
std::string program_file() {
  Dl_info here{};
  const bool is_module = dladdr(reinterpret_cast<const void*>(&program_file), &here) != 0 &&
                         here.dli_fname != nullptr && fs::path(here.dli_fname).extension() == ".so";
  return is_module ? here.dli_fname : "/proc/self/exe";
}

std::string processor_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

std::string system_name() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return fmt::format("{} {} {}", name.sysname, name.release, name.machine);
}

Json files_json(const std::vector<HashedFile>& files, const char* name, const char* path) {
  Json list = Json::array();
  for (const HashedFile& file : files) {
    Json entry = {{name, file.name}, {"sha256", file.sha256}};
    if (path) entry[path] = file.path;
    list.push_back(entry);
  }
  return list;
}

std::vector<HashedFile> files_of(const Json& list, const char* name, const char* path) {
  std::vector<HashedFile> files;
  for (const Json& entry : list) {
    const auto text = entry.at(name).get<std::string>();
    files.push_back({text, path ? entry.at(path).get<std::string>() : text, entry.at("sha256").get<std::string>()});
  }
  return files;
}

}  // namespace

std::string sha256_of_file(const std::string& path) {
  return sha256_of(read_input_file(path, std::numeric_limits<std::size_t>::max()));
}

std::vector<HashedFile> law_files(const Scene& scene, std::size_t stages) {
  std::set<std::string> laws;
  for (const auto& [name, family] : scene.joints) laws.insert(family.law);
  for (std::size_t i = 0; i < std::min(stages, scene.stages.size()); ++i) {
    for (const auto& [family, name] : scene.stages[i].law_swaps) laws.insert(name);
  }
  std::vector<HashedFile> files;
  for (const std::string& name : laws) {
    const std::string path = Law::find(name).library->path();
    files.push_back({name, path, sha256_of_file(path)});
  }
  return files;
}

std::vector<HashedFile> input_files(const Scene& scene) {
  std::vector<std::string> inputs = scene.inputs;
  std::error_code none;
  if (const fs::path start = fs::path(scene.start) / "end_state.bin"; !scene.start.empty() && fs::exists(start, none))
    inputs.push_back(start.string());
  std::vector<HashedFile> files;
  for (const std::string& file : inputs) files.push_back({file, file, sha256_of_file(file)});
  return files;
}

Provenance provenance_of(const Simulation& simulation, const Request& request) {
  const Scene& scene = simulation.scene();
  Provenance p;
  p.program = QUOIN_VERSION;
  static const std::string program_sha256 = sha256_of_file(program_file());  // of the process
  p.program_sha256 = program_sha256;
  p.compiler = __VERSION__;
  p.laws = law_files(scene);
  p.scene = scene.file;
  p.scene_text = scene.text;
  p.inputs = input_files(scene);
  for (const auto& [name, family] : scene.joints) {
    if (family.is_random()) p.seed = family.random.seed;
  }
  p.request = request;
  std::error_code none;
  p.working_directory = fs::current_path(none).string();
  p.processor = processor_name();
  p.system = system_name();
  p.instruction_set = kernel_instruction_set();
  p.memory = memory_here();
  p.threads = simulation.thread_count();
  return p;
}

void note_results(const Simulation& simulation, const fs::path& folder, Provenance* provenance) {
  provenance->state = fmt::format("{:016x}", simulation.hash());
  provenance->history_sha256.clear();
  std::error_code none;
  if (const fs::path history = folder / "history.csv"; fs::exists(history, none))
    provenance->history_sha256 = sha256_of_file(history.string());
}

Json to_json(const Provenance& p) {
  return {{"program", {{"version", p.program}, {"sha256", p.program_sha256}, {"compiler", p.compiler}}},
          {"laws", files_json(p.laws, "law", "library")},
          {"scene", {{"file", p.scene}, {"sha256", sha256_of(p.scene_text)}, {"text", p.scene_text}}},
          {"files", files_json(p.inputs, "file", nullptr)},
          {"law", p.request.law},
          {"set", p.request.overrides},
          {"working_directory", p.working_directory},
          {"machine", {{"processor", p.processor}, {"system", p.system}, {"memory_bytes", p.memory}}},
          {"instruction_set", p.instruction_set},
          {"threads", p.threads},
          {"seed", p.seed ? Json(*p.seed) : Json()},
          {"results", {{"state", p.state}, {"history_sha256", p.history_sha256}}}};
}

Provenance read_provenance(const fs::path& folder) {
  const fs::path path = folder / "summary.json";
  const auto refuse = [&](const std::string& why) { throw Error(Exit::bad_input, path.string() + ": " + why); };
  const Json summary = Json::parse(read_input_file(path.string()), nullptr, false);
  if (!summary.is_object() || !summary.contains("provenance"))
    refuse("does not say what the run was made from: no summary of this version of quoin; run the scene itself");
  if (summary.value("status", Json()) == "interrupted")
    refuse(fmt::format("the run was interrupted at a moment that is not in it; end it with quoin run --resume {}",
                       folder.string()));
  Provenance p;
  try {
    const Json& json = summary.at("provenance");
    p.program = json.at("program").at("version").get<std::string>();
    p.program_sha256 = json.at("program").at("sha256").get<std::string>();
    p.compiler = json.at("program").at("compiler").get<std::string>();
    p.laws = files_of(json.at("laws"), "law", "library");
    p.scene = json.at("scene").at("file").get<std::string>();
    p.scene_text = json.at("scene").at("text").get<std::string>();
    if (sha256_of(p.scene_text) != json.at("scene").at("sha256").get<std::string>())
      refuse("the text of the scene is not what was read then (its sha256 does not fit); run the scene itself");
    p.inputs = files_of(json.at("files"), "file", nullptr);
    p.request.law = json.at("law").get<std::string>();
    p.request.overrides = json.at("set").get<std::vector<std::string>>();
    p.working_directory = json.at("working_directory").get<std::string>();
    p.processor = json.at("machine").at("processor").get<std::string>();
    p.instruction_set = json.at("instruction_set").get<std::string>();
    p.state = json.at("results").at("state").get<std::string>();
    p.history_sha256 = json.at("results").at("history_sha256").get<std::string>();
  } catch (const Json::exception& error) {
    refuse(fmt::format("what the run was made from is not whole ({}); run the scene itself", error.what()));
  }
  return p;
}

std::vector<std::string> differences(const Provenance& here, const Provenance& there) {
  std::vector<std::string> all;
  const auto hold = [&](const std::string& what, const std::string& a, const std::string& b) {
    if (a != b) all.push_back(fmt::format("{}: {}, there {}", what, a.empty() ? "none" : a, b.empty() ? "none" : b));
  };
  const auto program = [](const Provenance& p) {
    return fmt::format("{} (sha256 {:.12}, {})", p.program, p.program_sha256, p.compiler);
  };
  hold("program", program(here), program(there));
  const auto files = [&](const char* kind, const std::vector<HashedFile>& a, const std::vector<HashedFile>& b) {
    for (const HashedFile& file : a) {
      const auto same = std::find_if(b.begin(), b.end(), [&](const HashedFile& f) { return f.name == file.name; });
      hold(fmt::format("{} {}", kind, file.name), "sha256 " + file.sha256,
           same == b.end() ? "" : "sha256 " + same->sha256);
    }
  };
  files("law", here.laws, there.laws);
  files("file", here.inputs, there.inputs);
  hold("instruction set", here.instruction_set, there.instruction_set);
  return all;
}

}  // namespace quoin
