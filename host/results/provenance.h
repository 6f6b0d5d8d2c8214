// What a run was made from: enough to run it again, and to see whether the bits are the same.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// What a command requested.
struct Request {
  std::string law;                     // in place of the scene's; empty: none
  std::vector<std::string> overrides;  // dotted.key=value, in their order
};

// A file by its bytes. Hashes are SHA-256, as sha256sum prints them.
struct HashedFile {
  std::string name;  // as the scene or the command names it
  std::string path;
  std::string sha256;
};

// SHA-256 of a file of any size. Throws Error(bad_input): it cannot be read.
std::string sha256_of_file(const std::string& path);
// Libraries of the laws of all stages. Throws as sha256_of_file, and Error(law_refused): there is no such law.
std::vector<HashedFile> law_files(const Scene& scene);
// Other files that the scene takes in: meshes, series, the end of the run that it begins from. Throws as
// sha256_of_file.
std::vector<HashedFile> input_files(const Scene& scene);

struct Provenance {
  std::string program, program_sha256, compiler;  // version, of the executable, what built it
  std::vector<HashedFile> laws;                   // laws of every stage
  std::string scene, scene_text;                  // file as it was named, and as it was read
  std::vector<HashedFile> inputs;                 // other files that the scene takes in
  std::optional<std::uint64_t> seed;              // seed of properties that scatter; empty: nothing is drawn
  Request request;
  std::string working_directory;  // where its paths count from
  std::string processor, system, instruction_set;
  double memory = 0.0;  // B
  int threads = 0;      // any number gives the same bits
  // What came out: the state of the model at the end, and history.csv. Empty: not known yet.
  std::string state, history_sha256;
};

// At the start of a run. Throws Error(bad_input): a file cannot be read.
Provenance provenance_of(const Simulation& simulation, const Request& request);
// At its end, with history.csv in FOLDER, or without.
void note_results(const Simulation& simulation, const std::filesystem::path& folder, Provenance* provenance);

nlohmann::ordered_json to_json(const Provenance& provenance);
// Provenance of FOLDER/summary.json. Throws Error(bad_input): there is none, it is not whole, or the run was
// interrupted.
Provenance read_provenance(const std::filesystem::path& folder);

// What is not the same in two of them and may change the bits: "program 0.1.0 (sha256 12ab...), there 0.1.0 (...)".
std::vector<std::string> differences(const Provenance& here, const Provenance& there);

}  // namespace quoin
