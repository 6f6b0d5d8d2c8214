// A wall of a study under one of its records, run repeatedly with other intensities.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ensemble/run_sample.h"
#include "ensemble/study.h"
#include "scene/scene.h"

namespace quoin::ensemble {

// A run of a wall under a record times a factor.
struct ShakenRun {
  std::string status;  // stands, collapsed, failed
  std::string reason;  // first collapse, or reason of the failure
  double factor = 0.0;
  Intensities intensity{};
  double largest = 0.0, residual = 0.0;  // displacement of any block against the ground, m: largest, and at the end
  double base_shear = 0.0;               // largest horizontal force on fixed blocks, N
  double time = 0.0;                     // s since the start of the stage, at its end
  bool collapsed() const { return status == "collapsed"; }
  bool failed() const { return status == "failed"; }
};

// Intensity of the next run after these, by the method of the suite; nothing: no further run.
std::optional<double> next_level(const RecordSuite& suite, const std::vector<ShakenRun>& runs, double of_record);

// Intensities between runs that stood and runs that reached a limit: a displacement, m, or collapse (0). A low of 0: no
// run below high stood. A high of infinity: no run reached the limit.
struct Bracket {
  double low = 0.0, high = HUGE_VAL;
};
Bracket bracket_of(const std::vector<ShakenRun>& runs, IntensityMeasure measure, double displacement);

// Outputs of samples.csv of a study with records.
std::vector<std::string> suite_output_names(const RecordSuite& suite);

// Computes all runs of a task, each in FOLDER/runs/NN. Runs with run.json, which is written last, are finished and not
// repeated. Then writes sample.json. Throws Error(bad_input) when the folder cannot be written.
void shake_sample(const Study& study, std::uint64_t task,
                  const std::function<Scene(const std::vector<std::string>& overrides)>& make_scene,
                  const std::filesystem::path& folder);

// Finished runs of a task.
std::vector<ShakenRun> read_runs(const std::filesystem::path& folder);

}  // namespace quoin::ensemble
