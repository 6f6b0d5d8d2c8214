// Runs of all studies, each computed once: DIR/runs/KEY/ holds what `quoin run` wrote, and a complete summary.json
// means that the run is done. Runs go side by side, each in a process of its own.
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
  std::vector<std::string> overrides;  // laid over every run
  int jobs = 1;
  bool again = false;  // whether finished runs are computed again
};

class RunCache {
 public:
  explicit RunCache(CacheSettings settings);

  // The key depends on the text of the scene, on what is laid over it, and on the program and the laws, byte by byte.
  std::string key(const RunSpec& spec) const;
  std::filesystem::path folder(const RunSpec& spec) const { return settings_.root / "runs" / key(spec); }
  bool done(const RunSpec& spec) const;

  // Computes what is not done yet, longest first; a line on stderr for each. A run that fails is reported and left;
  // throws Error(interrupted) after Ctrl-C, when all runs have stopped.
  void compute(const std::vector<RunSpec>& specs);
  RunResult result(const RunSpec& spec) const;

 private:
  CacheSettings settings_;
  std::uint64_t binaries_ = 0;  // hash of the program and of all laws that it finds by name
};

// The scenes that ship: $QUOIN_SCENES, host/scenes of the working directory or of the program's source tree, or
// ../share/quoin/scenes beside the program. Throws Error(bad_input).
std::filesystem::path find_scenes();

}  // namespace quoin::reproduce
