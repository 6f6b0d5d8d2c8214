// One sample: a scene computed in a folder of its own, with what went in and what came out in FOLDER/sample.json.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "ensemble/study.h"
#include "scene/scene.h"

namespace quoin::ensemble {

// Name and value, in the order of columns. Not a number: there is none.
using Values = std::vector<std::pair<std::string, double>>;

struct Sample {
  std::string status;  // done, failed
  std::string reason;  // reason of a failure
  Values inputs, outputs;
};

// Names of the outputs, whatever became of the sample.
std::vector<std::string> output_names();
// And of the inputs that a scattering property of a joint family adds: its mean by area, and its least value.
std::array<std::string, 2> drawn_columns(const std::string& family, const std::string& property);

// Computes the scene that make_scene reads with one thread. Writes history.csv, summary.json, cracks.csv, and at last
// sample.json, which marks the sample as finished. What the scene or the law makes impossible is a failed sample, not
// an error of this function. Throws Error(bad_input) where the folder cannot be written.
void run_sample(const Study& study, std::uint64_t number, const std::function<Scene()>& make_scene,
                const std::filesystem::path& folder);

// A sample whose process ended before it could say so.
void write_failed(const Study& study, std::uint64_t number, const std::filesystem::path& folder,
                  const std::string& reason);

// sample.json of a finished sample. Throws Error(bad_input) where it is none.
Sample read_sample(const std::filesystem::path& folder);
bool is_finished(const std::filesystem::path& folder);

// Joints that have opened, as cracks.csv has them.
struct OpenedJoint {
  int block_a, block_b;
  double x0, y0, x1, y1;  // m, ends of the joint in the plane of the wall
  double opening;         // m, the largest
};
std::vector<OpenedJoint> read_joints(const std::filesystem::path& folder);  // none: not there

}  // namespace quoin::ensemble
