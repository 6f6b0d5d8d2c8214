// Inputs and program of a run: all that is needed to repeat it and to compare its bits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Options of a command.
struct Request {
  std::string law;                     // law in place of the scene's; empty: none
  std::vector<std::string> overrides;  // dotted.key=value, in their order
};

// A file with its hash. Hashes are SHA-256, as printed by sha256sum.
struct HashedFile {
  std::string name;  // name in the scene or the command
  std::string path;
  std::string sha256;
};

// SHA-256 of a file of any size. Throws Error(bad_input): it cannot be read.
std::string sha256_of_file(const std::string& path);
// Libraries of the laws of all stages. Throws as sha256_of_file, and Error(law_refused) for a law that does not exist.
// stages: how many first stages count, with the laws that they swap in.
std::vector<HashedFile> law_files(const Scene& scene, std::size_t stages = SIZE_MAX);
// Other files that the scene reads: meshes, series, the end state of another run. Throws as sha256_of_file.
std::vector<HashedFile> input_files(const Scene& scene);

struct Provenance {
  std::string program, program_sha256, compiler;  // version; hash of the executable; compiler that built it
  std::vector<HashedFile> laws;                   // laws of every stage
  std::string scene, scene_text;                  // file name as given, and the text as read
  std::vector<HashedFile> inputs;                 // other files that the scene reads
  std::optional<std::uint64_t> seed;              // seed of properties that scatter; empty: nothing is drawn
  Request request;
  std::string working_directory;  // folder of relative paths
  std::string processor, system, instruction_set;
  double memory = 0.0;  // B
  int threads = 0;      // the bits do not depend on it
  // Hashes of the results: the final state of the model, and history.csv. Empty: not computed yet.
  std::string state, history_sha256;
};

// Provenance of a run at its start. Throws Error(bad_input) for a file that cannot be read.
Provenance provenance_of(const Simulation& simulation, const Request& request);
// Adds the hashes of results at the end. Without history.csv in FOLDER its hash stays empty.
void note_results(const Simulation& simulation, const std::filesystem::path& folder, Provenance* provenance);

nlohmann::ordered_json to_json(const Provenance& provenance);
// Provenance in FOLDER/summary.json. Throws Error(bad_input) for a file that is missing or damaged, or that of an
// interrupted run.
Provenance read_provenance(const std::filesystem::path& folder);

// Differences of two provenances that may change the bits: "program 0.1.0 (sha256 12ab...), there 0.1.0 (...)".
std::vector<std::string> differences(const Provenance& here, const Provenance& there);

}  // namespace quoin
