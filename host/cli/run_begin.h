// How a run begins, on one process and on each of several ranks.
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
// Pieces of frames; one process alone writes all of them.
Pieces pieces_of(const Scene& scene, const Ranks* ranks);
// Where the run in this folder was kept, or where its scene starts.
void begin(Simulation* simulation, const std::filesystem::path& folder, const StoredState& kept);

// What the others need to write files of their own into the folder of results: where it is, and the token of its
// manifest. The frames that are there.
struct SharedFolder {
  std::string path, token;
  std::vector<double> frame_times;
};
void share(Ranks& ranks, SharedFolder& folder);  // from rank 0 to all others

}  // namespace quoin
