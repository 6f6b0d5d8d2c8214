// Runs of all studies, each computed once. DIR/runs/KEY/ has the results of `quoin run`, and a complete summary.json
// marks the run as done. Several runs are computed at the same time, each in a process of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "reproduce/study.h"

namespace quoin::reproduce {

struct CacheSettings {
  std::filesystem::path root;          // DIR
  std::filesystem::path scenes;        // folder of the shipped scenes
  std::vector<std::string> overrides;  // overrides of every run
  int jobs = 1;
  bool again = false;  // whether finished runs are computed again
};

class RunCache {
 public:
  explicit RunCache(CacheSettings settings);

  // Hash of the scene's text, of its overrides, and of program and laws, byte by byte.
  std::string key(const RunSpec& spec) const;
  std::filesystem::path folder(const RunSpec& spec) const { return settings_.root / "runs" / key(spec); }
  bool done(const RunSpec& spec) const;

  // Computes runs that are not done, longest first, with a line on stderr for each. Reports failed runs and continues.
  // Throws Error(interrupted) after Ctrl-C, when all runs have stopped. Returns the exit code of a run that was refused
  // for its input, or else of the last one that failed; 0: none did.
  int compute(const std::vector<RunSpec>& specs);
  RunResult result(const RunSpec& spec) const;

 private:
  CacheSettings settings_;
  std::uint64_t binaries_ = 0;  // hash of the program and of all installed laws
};

// Folder of the shipped scenes. It is $QUOIN_SCENES, host/scenes of the working directory or of the program's source
// tree, or ../share/quoin/scenes next to the program. Throws Error(bad_input) without any.
std::filesystem::path find_scenes();

}  // namespace quoin::reproduce
