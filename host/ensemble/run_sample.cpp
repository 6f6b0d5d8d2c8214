#include "ensemble/run_sample.h"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "base/any_error.h"
#include "base/error.h"
#include "base/input_file.h"
#include "ensemble/no_number.h"
#include "files/result_folder.h"
#include "results/checkpoint_file.h"
#include "results/history.h"
#include "results/json_file.h"
#include "results/parted_joints.h"
#include "results/plots.h"
#include "results/provenance.h"
#include "results/summary.h"
#include "results/warnings.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kLoss = 0.8;  // share of the peak force

Json json_of(const Values& values) {
  Json json = Json::object();
  for (const auto& [name, value] : values) json[name] = std::isfinite(value) ? Json(value) : Json(nullptr);
  return json;
}
Values values_of(const Json& json) {
  Values values;
  for (const auto& [name, value] : json.items())
    values.emplace_back(name, value.is_number() ? value.get<double>() : kNone);
  return values;
}

// Tables of a sample from which curves and cracks of the study are read.
constexpr const char* kTables[] = {"history.csv", "cracks.csv"};

}  // namespace

void write_sample(const fs::path& folder, const Sample& sample) {
  Json bytes = Json::object();
  for (const char* table : kTables) {
    if (fs::exists(folder / table)) bytes[table] = fs::file_size(folder / table);
  }
  write_json(folder / "sample.json", {{"status", sample.status},
                                      {"reason", sample.reason},
                                      {"inputs", json_of(sample.inputs)},
                                      {"outputs", json_of(sample.outputs)},
                                      {"bytes", bytes}});
}

Values inputs_of(const Study& study, std::uint64_t task) {
  const bool shaken = study.suite.any();
  const std::uint64_t sample = shaken ? study.wall_of(task) : task;
  Values inputs;
  if (shaken) {
    inputs.emplace_back("record", static_cast<double>(study.record_of(task) + 1));
    inputs.emplace_back("wall", static_cast<double>(sample));
  }
  const std::vector<double> drawn = study.values(sample);
  const std::vector<StudyQuantity> known = study.inputs();
  for (std::size_t i = 0; i < drawn.size(); ++i) inputs.emplace_back(known[i].name, drawn[i]);
  return inputs;
}

void write_run_summary(const fs::path& folder, const Simulation& simulation, const std::vector<HistoryRow>& rows,
                       const std::string& status, const std::string& message,
                       const std::vector<std::string>& overrides) {
  RunInfo info;
  info.provenance.request.overrides = overrides;
  info.status = status, info.message = message;
  info.quasi_static = check_quasi_static(rows, simulation.scene());
  info.crushed_out = find_crushed_out(simulation);
  info.warnings = warnings_of(simulation, info.quasi_static, info.crushed_out);
  write_summary(folder / "summary.json", simulation, rows, info);
}

namespace {

class Recorder : public Observer {
 public:
  Recorder(const fs::path& folder, const Simulation& simulation) : history_(folder / "history.csv", simulation) {}
  void on_row(const HistoryRow& row) override { history_.add(row); }
  History& history() { return history_; }

 private:
  History history_;
};

// Adds mean by area and least value of each random property of joints.
void add_drawn(const Simulation& simulation, Values& inputs) {
  const auto add = [&](const std::string& family, const PropertyColumn& column, const auto& area_of) {
    if (!column.is_drawn) return;
    double sum = 0.0, area = 0.0, least = HUGE_VAL;
    for (std::size_t i = 0; i < column.values.size(); ++i) {
      sum += area_of(i) * column.values[i], area += area_of(i);
      least = std::min(least, column.values[i]);
    }
    const auto [name_of_mean, name_of_least] = drawn_columns(family, column.id);
    inputs.emplace_back(name_of_mean, sum / area);
    inputs.emplace_back(name_of_least, least);
  };
  const auto& names = simulation.assembly().families;
  if (const blocks::Model* large_motion = simulation.large_motion()) {
    for (std::size_t f = 0; f < large_motion->contacts.families.size(); ++f) {
      const blocks::Family& family = large_motion->contacts.families[f];
      for (const PropertyColumn& c : family.columns)
        add(names[f].name, c, [&](std::size_t i) { return family.point[i].area; });
    }
    return;
  }
  const Model& model = simulation.model();
  for (const ContactFamily& family : model.families) {
    for (const PropertyColumn& c : family.columns)
      add(family.name, c, [&](std::size_t i) { return model.area[static_cast<std::size_t>(family.first_point) + i]; });
  }
}

// Outputs of the last stage, which drives the wall.
Values outputs_of(const Simulation& simulation, const std::vector<HistoryRow>& rows) {
  const Scene& scene = simulation.scene();
  const Peak peak = find_peak(rows, scene);
  const int last = static_cast<int>(scene.stages.size()) - 1;
  double work = 0.0, final_force = kNone;
  const HistoryRow* before = nullptr;
  for (const HistoryRow& row : rows) {
    if (row.stage != last) continue;
    const Shown now = shown(row, scene);
    final_force = now.force;
    if (before) {
      const Shown then = shown(*before, scene);
      work += 0.5 * (now.force + then.force) * (now.displacement - then.displacement);
    }
    before = &row;
  }
  const double height = scene.wall && !is_vertical(scene) ? scene.wall->courses * scene.wall->unit[1] : kNone;
  const auto multiplier = simulation.outcome().collapse_multiplier;
  const std::vector<double> values{peak.row < 0 ? kNone : peak.force,
                                   peak.row < 0 ? kNone : peak.displacement,
                                   peak.row < 0 ? kNone : peak.displacement / height,
                                   peak.row < 0 ? kNone : peak.vertical_force,
                                   displacement_at_loss(rows, scene, peak, kLoss).value_or(kNone),
                                   work,
                                   final_force,
                                   multiplier ? *multiplier : kNone,
                                   simulation.outcome().promotion ? 1.0 : 0.0};
  Values outputs;
  const std::vector<std::string> names = output_names();
  for (std::size_t i = 0; i < names.size(); ++i) outputs.emplace_back(names[i], values[i]);
  return outputs;
}

// Writes the largest opening of every joint, with the corners of the box around it.
void write_joints(const Simulation& simulation, const fs::path& file) {
  std::map<std::pair<int, int>, OpenedJoint> joints;
  const auto add = [&](int block_a, int block_b, const Vec3& place, double opening) {
    const auto key = std::minmax(block_a, block_b);
    auto [found, is_new] = joints.try_emplace(key, OpenedJoint{key.first, key.second, place, place, 0.0});
    OpenedJoint& j = found->second;
    for (std::size_t c = 0; c < 3; ++c)
      j.low[c] = std::min(j.low[c], place[c]), j.high[c] = std::max(j.high[c], place[c]);
    j.opening = std::max(j.opening, opening);
  };
  for (const ContactPoint& p : contact_points(simulation)) add(p.block_a, p.block_b, p.position, p.jump[0]);
  for (const PartedPoint& p : parted_points(simulation)) {
    const ContactPoint& last = p.joint.contact;
    add(last.block_a, last.block_b, last.position, p.joint.opening);
  }
  std::string text = "block_a,block_b,x0_m,y0_m,x1_m,y1_m,opening_m,z0_m,z1_m\n";
  for (const auto& [key, j] : joints)
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", j.block_a, j.block_b, j.low[0], j.low[1], j.high[0], j.high[1],
                        j.opening, j.low[2], j.high[2]);
  write_file(file, text);
}

// The end state of another run is not copied, as it is large, and may have been replaced.
void require_start(const Study& study) {
  if (study.start.empty() || sha256_of_file(study.start) == study.start_sha256) return;
  throw Error(Exit::bad_input,
              fmt::format("{}: start: {} has changed since the study was begun; bring back the file of then, or begin "
                          "another study with --out",
                          study.scene, study.start));
}

// Message with the scene's file name in place of its path, which differs between machines.
std::string without_path(std::string reason, const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  for (std::size_t at = reason.find(path); !path.empty() && at != std::string::npos; at = reason.find(path, at + 1))
    reason.replace(at, path.size(), name);
  return reason;
}

}  // namespace

std::vector<std::string> output_names() {
  return {"peak_force_N",
          "displacement_at_peak_m",
          "drift_at_peak",
          "vertical_force_at_peak_N",
          "displacement_at_20_percent_loss_m",
          "work_J",
          "last_force_N",
          "collapse_multiplier",
          "large_motion"};
}

std::array<std::string, 2> drawn_columns(const std::string& family, const std::string& property) {
  return {fmt::format("joints.{}.{}_mean", family, property), fmt::format("joints.{}.{}_least", family, property)};
}

void run_sample(const Study& study, std::uint64_t number, const std::function<Scene()>& make_scene,
                const fs::path& folder) {
  const ResultFolder own(folder);
  Sample sample{"done", "", inputs_of(study, number), {}};
  const auto fail = [&](const std::string& why) {
    sample.status = "failed";
    sample.reason = without_path(why, study.scene);
  };
  // A full disk is no property of the sample: errors of writing are thrown.
  const auto attempt = [&](const auto& what) {
    try {
      what();
    } catch (const Error& error) {
      if (error.exit_code != Exit::numerical && error.exit_code != Exit::law_refused) throw;
      fail(error.what());
    } catch (const std::exception& error) {
      fail(any_error(error).what());
    }
  };
  std::optional<Simulation> simulation;
  attempt([&] {
    try {
      simulation.emplace(make_scene(), 1);
      take_start(&*simulation);
    } catch (const Error& error) {  // the scene of this sample is at fault
      simulation.reset();
      fail(error.what());
    }
  });
  require_start(study);
  if (simulation) {
    add_drawn(*simulation, sample.inputs);
    Recorder recorder(folder, *simulation);
    attempt([&] { simulation->run(recorder); });
    // Without its multiplier a weak sample would count as one that has not reached a limit.
    for (const Warning& warning : simulation->outcome().warnings)
      if (sample.status == "done" && warning.about == "collapse_multiplier") fail(warning.text);
    recorder.history().finish();
    const auto& rows = recorder.history().rows();
    write_run_summary(folder, *simulation, rows, sample.status, sample.reason, study.overrides_of(number));
    write_joints(*simulation, folder / "cracks.csv");
    sample.outputs = outputs_of(*simulation, rows);
  }
  write_sample(folder, sample);
}

void write_failed(const Study& study, std::uint64_t task, const fs::path& folder, const std::string& reason) {
  write_sample(folder, {"failed", without_path(reason, study.scene), inputs_of(study, task), {}});
}

bool is_finished(const fs::path& folder) {
  std::error_code unknown;
  return fs::exists(folder / "sample.json", unknown);
}

Sample read_sample(const fs::path& folder) {
  const std::string path = (folder / "sample.json").string();
  const Json json = Json::parse(read_input_file(path), nullptr, false);
  if (!json.is_object() || !json.contains("status") || !json.contains("inputs") || !json.contains("outputs"))
    throw Error(Exit::bad_input, path + ": is no sample of a study; remove it, and the sample is computed anew");
  const Json written = json.value("bytes", Json::object());
  for (const auto& [table, bytes] : written.items()) {
    std::error_code missing;
    if (fs::file_size(folder / table, missing) != bytes)
      throw Error(
          Exit::bad_input,
          fmt::format("{}: is missing or has not the {} bytes that were written; remove sample.json beside it, and "
                      "the sample is computed anew",
                      (folder / table).string(), bytes.dump()));
  }
  return {json["status"].get<std::string>(), json.value("reason", ""), values_of(json["inputs"]),
          values_of(json["outputs"])};
}

std::vector<OpenedJoint> read_joints(const fs::path& folder) {
  std::ifstream stream(folder / "cracks.csv");
  std::string line;
  std::vector<OpenedJoint> joints;
  std::getline(stream, line);
  while (std::getline(stream, line)) {
    OpenedJoint j{};
    if (std::sscanf(line.c_str(), "%d,%d,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &j.block_a, &j.block_b, &j.low[0], &j.low[1],
                    &j.high[0], &j.high[1], &j.opening, &j.low[2], &j.high[2]) == 9)
      joints.push_back(j);
  }
  return joints;
}

}  // namespace quoin::ensemble
