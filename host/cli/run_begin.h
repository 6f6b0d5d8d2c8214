// Start of a run, on one process or on several ranks.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/ranks.h"
#include "cli/run_options.h"
#include "results/checkpoint_file.h"
#include "results/vtk.h"
#include "step/simulation.h"

namespace quoin {

Scene scene_of(RunOptions* options, const Ranks* ranks);
int threads_of(const RunOptions& options, const Ranks* ranks);
// Pieces of frames by rank; one process alone writes whole frames.
Pieces pieces_of(const Scene& scene, const Ranks* ranks);
// Sets the state of the checkpoint `kept` in this folder, or the initial state of the scene.
void begin(Simulation* simulation, const std::filesystem::path& folder, const StoredState& kept);

// Data for files of other ranks in the folder of results: its path, the token of its manifest, and the times of its
// frames.
struct SharedFolder {
  std::string path, token;
  std::vector<double> frame_times;
};
void share(Ranks& ranks, SharedFolder& folder);  // from rank 0 to all others

}  // namespace quoin
