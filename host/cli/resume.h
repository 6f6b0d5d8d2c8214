// Continuation of runs that were stopped: their request in DIR/run.json, and their checkpoints.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "cli/run_options.h"
#include "results/checkpoint_file.h"

namespace quoin {

// Writes to FOLDER/run.json the options on which results depend, and the hash of the scene's text. Also the working
// directory, to which paths are relative.
void write_run_record(const std::filesystem::path& folder, const RunOptions& options, const std::string& scene_text);

// Reads FOLDER/run.json, and changes to the working directory of the run. Options of results are added to those given.
// Throws Error(bad_input) if FOLDER has no run, or the working directory does not exist.
void read_run_record(const std::filesystem::path& folder, RunOptions* options);

// Whether the run in FOLDER is complete, by its summary.json. The last thing that a run does is to delete its
// checkpoint.
bool is_done(const std::filesystem::path& folder);

// Whether a run resumed after `frames` frames keeps this result of FOLDER.
bool is_kept(const std::string& name, std::size_t frames);
// Prints which of these frames are no longer in the folder.
void say_what_is_missing(const std::filesystem::path& folder, std::size_t frames);

// Decides when a checkpoint is due.
class CheckpointClock {
 public:
  // every: s between checkpoints, 0: none at all.
  explicit CheckpointClock(double every) : every_(every) {}
  bool on() const { return every_ > 0.0; }
  bool due() const { return on() && std::chrono::duration<double>(Clock::now() - last_).count() >= every_; }
  void taken() { last_ = Clock::now(); }  // counts from its end, so that a slow disk does not take all of the time

 private:
  using Clock = std::chrono::steady_clock;
  double every_;
  Clock::time_point last_ = Clock::now();
};

}  // namespace quoin
