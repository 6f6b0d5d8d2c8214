// One sample: a scene computed in a folder of its own, with its inputs and outputs in FOLDER/sample.json.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "ensemble/study.h"
#include "scene/scene.h"
#include "step/simulation.h"

namespace quoin::ensemble {

// Name and value, in the order of columns. NaN: missing.
using Values = std::vector<std::pair<std::string, double>>;

struct Sample {
  std::string status;  // done, failed
  std::string reason;  // reason of a failure
  Values inputs, outputs;
};

// Values of the study's quantities in a task; with records, before them the numbers of its record and wall, from 1.
Values inputs_of(const Study& study, std::uint64_t task);
// Writes FOLDER/sample.json, which marks a task as finished.
void write_sample(const std::filesystem::path& folder, const Sample& sample);
// Writes FOLDER/summary.json. status: done or failed, with its message.
void write_run_summary(const std::filesystem::path& folder, const Simulation& simulation,
                       const std::vector<HistoryRow>& rows, const std::string& status, const std::string& message,
                       const std::vector<std::string>& overrides);

// Names of the outputs of every sample.
std::vector<std::string> output_names();
// Names of the inputs for a random property of a joint family: its mean by area, and its least value.
std::array<std::string, 2> drawn_columns(const std::string& family, const std::string& property);

// Computes the scene returned by make_scene with one thread. Writes history.csv, summary.json, cracks.csv, and at last
// sample.json, which marks the sample as finished. Errors of the scene or of the law make a failed sample; they are not
// thrown. Throws Error(bad_input) when the folder cannot be written.
void run_sample(const Study& study, std::uint64_t number, const std::function<Scene()>& make_scene,
                const std::filesystem::path& folder);

// Records a failed task whose process ended without a record.
void write_failed(const Study& study, std::uint64_t task, const std::filesystem::path& folder,
                  const std::string& reason);

// sample.json of a finished sample. Throws Error(bad_input) for a file that is not valid.
Sample read_sample(const std::filesystem::path& folder);
bool is_finished(const std::filesystem::path& folder);

// A joint with an opening, as in cracks.csv.
struct OpenedJoint {
  int block_a, block_b;
  Vec3 low, high;  // corners of the box around the joint, m
  double opening;  // m; largest of its points
};
std::vector<OpenedJoint> read_joints(const std::filesystem::path& folder);  // empty: no file

}  // namespace quoin::ensemble
