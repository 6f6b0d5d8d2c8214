// Runs that go on after they were stopped: what DIR/run.json says of a run, and the checkpoints that it leaves.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/prepare.h"
#include "results/checkpoint_file.h"

namespace quoin {

// Writes to FOLDER/run.json the request of a run, the hash of the text of its scene, and its working folder. Its
// paths count from there.
void write_run_record(const std::filesystem::path& folder, const SceneOptions& options, const std::string& scene_text);

// The same read, and the working directory changed to where the run was started. Throws Error(bad_input): no run was
// begun in FOLDER, or its working directory is gone.
SceneOptions read_run_record(const std::filesystem::path& folder);

// Whether the run in FOLDER has come to its end: summary.json says so.
bool is_done(const std::filesystem::path& folder);

// Whether a resumed run with so many frames keeps this result of FOLDER.
bool is_kept(const std::string& name, std::size_t frames);

// Decides when a checkpoint is due.
class CheckpointClock {
 public:
  // every: s between checkpoints, 0: none at all.
  explicit CheckpointClock(double every) : every_(every) {}
  bool on() const { return every_ > 0.0; }
  bool due() const { return on() && std::chrono::duration<double>(Clock::now() - last_).count() >= every_; }
  void taken() { last_ = Clock::now(); }  // from its end on, so that slow disks do not get all of the time

 private:
  using Clock = std::chrono::steady_clock;
  double every_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace quoin
