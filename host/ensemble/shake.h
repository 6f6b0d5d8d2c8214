// A wall of a study under one of its records, again and again at other intensities.
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

// One run of a wall under a record times a factor.
struct ShakenRun {
  std::string status;  // stands, collapsed, failed
  std::string reason;  // what collapsed first, or why the run failed
  double factor = 0.0;
  Intensities intensity{};
  double largest = 0.0, residual = 0.0;  // displacement of any block against the ground: at most, at the end, m
  double base_shear = 0.0;               // largest horizontal force on what is fixed, N
  double time = 0.0;                     // s of the stage, when it ended
  bool collapsed() const { return status == "collapsed"; }
  bool failed() const { return status == "failed"; }
};

// The intensity of the next run after these, by the method of the suite; nothing: there is none to come.
std::optional<double> next_level(const RecordSuite& suite, const std::vector<ShakenRun>& runs, double of_record);

// Between what stood and what reached the limit: a limit of displacement, m, or collapse (0). low 0: nothing below high
// stood; high infinite: nothing reached it.
struct Bracket {
  double low = 0.0, high = HUGE_VAL;
};
Bracket bracket_of(const std::vector<ShakenRun>& runs, IntensityMeasure measure, double displacement);

// Outputs of samples.csv of a study with records.
std::vector<std::string> suite_output_names(const RecordSuite& suite);

// All runs of a task, each in FOLDER/runs/NN with run.json, which comes last: what is finished there is not computed
// again. Then sample.json. Throws Error(bad_input) where the folder cannot be written.
void shake_sample(const Study& study, std::uint64_t task,
                  const std::function<Scene(const std::vector<std::string>& overrides)>& make_scene,
                  const std::filesystem::path& folder);

// Those of a task that are finished.
std::vector<ShakenRun> read_runs(const std::filesystem::path& folder);

}  // namespace quoin::ensemble
