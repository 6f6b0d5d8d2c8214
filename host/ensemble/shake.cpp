#include "ensemble/shake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/any_error.h"
#include "base/error.h"
#include "base/input_file.h"
#include "base/upright_axis.h"
#include "ensemble/no_number.h"
#include "files/file.h"
#include "model/world_results.h"
#include "results/checkpoint_file.h"
#include "results/history.h"
#include "results/json_file.h"
#include "results/plots.h"
#include "step/findings.h"
#include "step/large_motion.h"
#include "step/results.h"
#include "step/simulation.h"

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kLeastOfFirst = 1e-3;  // share of the first level below which no collapse is sought
constexpr double kSunk = 0.5;           // share of its height by which a block sinks that has lost its support

double number_in(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number() ? json[key].get<double>() : kNone;
}

fs::path folder_of(const fs::path& folder, std::size_t run) { return folder / "runs" / fmt::format("{:02}", run); }

void write_run(const fs::path& folder, const ShakenRun& run) {
  Json json{{"status", run.status}, {"reason", run.reason}, {"factor", run.factor}};
  for (std::size_t m = 0; m < kMeasures; ++m) json[kMeasureNames[m].column] = number_or_null(run.intensity[m]);
  json["largest_displacement_m"] = number_or_null(run.largest);
  json["residual_displacement_m"] = number_or_null(run.residual);
  json["largest_base_shear_N"] = number_or_null(run.base_shear);
  json["time_s"] = number_or_null(run.time);
  write_json(folder / "run.json", json);
}

ShakenRun read_run(const fs::path& file) {
  const Json json = Json::parse(read_input_file(file.string()), nullptr, false);
  if (!json.is_object() || !json.contains("status") || !json.contains("factor"))
    throw Error(Exit::bad_input, file.string() + ": is no run of a study; remove it, and it is computed anew");
  ShakenRun run;
  run.status = json["status"].get<std::string>(), run.reason = json.value("reason", "");
  run.factor = number_in(json, "factor");
  for (std::size_t m = 0; m < kMeasures; ++m) run.intensity[m] = number_in(json, kMeasureNames[m].column);
  run.largest = number_in(json, "largest_displacement_m"), run.residual = number_in(json, "residual_displacement_m");
  run.base_shear = number_in(json, "largest_base_shear_N"), run.time = number_in(json, "time_s");
  return run;
}

// Observer that measures, at every row from the first stage with ground motion on, how far blocks have moved against
// the ground. It ends the run at collapse.
class CollapseWatch : public Observer {
 public:
  CollapseWatch(const fs::path& folder, Simulation* simulation, const RecordSuite& suite)
      : history_(folder / "history.csv", *simulation),
        simulation_(simulation),
        suite_(suite),
        begin_(simulation->time()) {
    for (int block = 0; block < simulation->block_count(); ++block) {
      Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
      for (const Vec3& x : block_mesh(*simulation, block).gridpoint) {
        for (std::size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], x[c]), high[c] = std::max(high[c], x[c]);
      }
      extent_.push_back(high - low);
    }
  }

  void on_row(const HistoryRow& row) override {
    history_.add(row);
    const Stage& stage = simulation_->scene().stages[static_cast<std::size_t>(row.stage)];
    shaken_ = shaken_ || stage.ground;
    if (!shaken_) {
      begin_ = row.time;
      return;
    }
    run.time = row.time - begin_;
    Vec3 shear = row.base_force;
    shear[static_cast<std::size_t>(upright_axis(stage.gravity))] = 0.0;
    run.base_shear = std::max(run.base_shear, norm_of(shear));
    run.residual = 0.0;
    const blocks::Model* const model = simulation_->large_motion();
    for (int block = 0; block < simulation_->block_count(); ++block) {
      const auto i = static_cast<std::size_t>(block);
      if (model ? model->assembly.blocks[i].fixed : simulation_->assembly().bricks[i].fixed) continue;
      look(model ? translation_of(*model, block) : translation_on_lattice(block), block, row, stage.gravity);
    }
    run.largest = std::max(run.largest, run.residual);
    if (run.collapsed()) simulation_->request_stop();
  }

  History& history() { return history_; }
  ShakenRun run;

 private:
  // One step ago, as the ground's displacement in a row.
  Vec3 translation_of(const blocks::Model& model, int block) const {
    const double step = simulation_->time_step_report().time_step;
    return geometry::array(position_of(model, block) - step * velocity_of(model, block) -
                           start_position_of(model, block));
  }
  Vec3 translation_on_lattice(int block) const {
    const double step = simulation_->time_step_report().time_step;
    const std::vector<Vec3> moved = block_displacement(*simulation_, block), v = block_velocity(*simulation_, block);
    Vec3 mean{};
    for (std::size_t i = 0; i < moved.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) mean[c] += (moved[i][c] - step * v[i][c]) / static_cast<double>(moved.size());
    }
    return mean;
  }

  void look(const Vec3& moved, int block, const HistoryRow& row, const Vec3& gravity) {
    double square = 0.0, sunk = 0.0, height = 0.0;
    const double g = std::hypot(gravity[0], gravity[1], gravity[2]);
    for (std::size_t c = 0; c < 3; ++c) {
      const double on_ground = moved[c] - row.ground_displacement[c];
      square += on_ground * on_ground;
      if (g <= 0.0) continue;
      sunk += on_ground * gravity[c] / g;
      height += extent_[static_cast<std::size_t>(block)][c] * std::abs(gravity[c]) / g;
    }
    const double distance = std::sqrt(square);
    run.residual = std::max(run.residual, distance);
    const bool far = distance >= suite_.displacement, fallen = height > 0.0 && sunk >= kSunk * height;
    if (run.collapsed() || (!far && !fallen)) return;
    run.status = "collapsed";
    run.reason = fmt::format("{}: {}", block_label(*simulation_, block),
                             fallen ? "has lost its support" : "has reached the displacement of collapse");
  }

  History history_;
  Simulation* simulation_;
  const RecordSuite& suite_;
  std::vector<Vec3> extent_;
  bool shaken_ = false;  // whether a stage with ground motion has begun
  double begin_;         // s, when it began
};

// Computes one run. Errors of the scene or of the law make it a failed run.
ShakenRun shake(const Study& study, const std::function<Scene(const std::vector<std::string>&)>& make_scene,
                const std::vector<std::string>& overrides, const fs::path& folder) {
  make_folder(folder);
  ShakenRun failed;
  failed.status = "failed";
  std::optional<Simulation> simulation;
  try {
    simulation.emplace(make_scene(overrides), 1);
    take_start(&*simulation);
  } catch (const Error& error) {
    failed.reason = error.what();
    return failed;
  }
  CollapseWatch watch(folder, &*simulation, study.suite);
  watch.run.status = "stands";
  try {
    simulation->run(watch);
  } catch (const Error& error) {
    const bool stopped = error.exit_code == Exit::interrupted && watch.run.collapsed();
    if (error.exit_code == Exit::bad_input) throw;
    if (!stopped) watch.run.status = "failed", watch.run.reason = error.what();
  } catch (const std::exception& error) {
    watch.run.status = "failed", watch.run.reason = any_error(error).what();
  }
  watch.history().finish();
  write_run_summary(folder, *simulation, watch.history().rows(), watch.run.failed() ? "failed" : "done",
                    watch.run.reason, overrides);
  return watch.run;
}

Values outputs_of(const RecordSuite& suite, const std::vector<ShakenRun>& runs) {
  Values outputs{{"runs", static_cast<double>(runs.size())}};
  if (suite.method != RecordSuite::Method::incremental) return outputs;
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const auto measure = static_cast<IntensityMeasure>(m);
    const Bracket b = bracket_of(runs, measure, 0.0);
    const std::string column = names_of(measure).column;
    outputs.emplace_back("stands_" + column, b.low);
    outputs.emplace_back("collapse_" + column,
                         b.low > 0.0 && std::isfinite(b.high) ? std::sqrt(b.low * b.high) : kNone);
  }
  return outputs;
}

}  // namespace

std::vector<std::string> suite_output_names(const RecordSuite& suite) {
  std::vector<std::string> names{"runs"};
  if (suite.method != RecordSuite::Method::incremental) return names;
  for (std::size_t m = 0; m < kMeasures; ++m) {
    const std::string column = kMeasureNames[m].column;
    names.push_back("stands_" + column), names.push_back("collapse_" + column);
  }
  return names;
}

std::optional<double> next_level(const RecordSuite& suite, const std::vector<ShakenRun>& runs, double of_record) {
  using Method = RecordSuite::Method;
  if (!runs.empty() && runs.back().failed()) return std::nullopt;
  if (suite.method == Method::cloud) return runs.empty() ? std::optional(of_record) : std::nullopt;
  if (suite.method == Method::stripes)
    return runs.size() < suite.levels.size() ? std::optional(suite.levels[runs.size()]) : std::nullopt;
  if (runs.empty()) return suite.first;
  const Bracket b = bracket_of(runs, suite.measure, 0.0);
  if (!std::isfinite(b.high)) {
    // The level of a run is a product, so that the largest one has rounding.
    if (b.low >= suite.largest * (1.0 - 1e-9)) return std::nullopt;
    return std::min(b.low * suite.growth, suite.largest);
  }
  if (b.low == 0.0) {
    const double lower = b.high / suite.growth;
    return lower < kLeastOfFirst * suite.first ? std::nullopt : std::optional(lower);
  }
  return b.high <= b.low * (1.0 + suite.tolerance) ? std::nullopt : std::optional(std::sqrt(b.low * b.high));
}

Bracket bracket_of(const std::vector<ShakenRun>& runs, IntensityMeasure measure, double displacement) {
  const auto m = static_cast<std::size_t>(measure);
  Bracket b;
  const auto reached = [&](const ShakenRun& run) {
    return run.collapsed() || (displacement > 0.0 && run.largest >= displacement);
  };
  for (const ShakenRun& run : runs) {
    if (!run.failed() && reached(run)) b.high = std::min(b.high, run.intensity[m]);
  }
  for (const ShakenRun& run : runs) {
    if (!run.failed() && !reached(run) && run.intensity[m] < b.high) b.low = std::max(b.low, run.intensity[m]);
  }
  return b;
}

void shake_sample(const Study& study, std::uint64_t task,
                  const std::function<Scene(const std::vector<std::string>&)>& make_scene, const fs::path& folder) {
  const std::size_t record = study.record_of(task);
  const std::vector<std::string> of_wall = study.overrides_of(study.wall_of(task));
  const SuiteMotion motion = motion_of(study.suite, record);
  const double of_record = motion.intensity[static_cast<std::size_t>(study.suite.measure)];
  std::vector<ShakenRun> runs = read_runs(folder);
  for (auto level = next_level(study.suite, runs, of_record); level; level = next_level(study.suite, runs, of_record)) {
    const fs::path place = folder_of(folder, runs.size() + 1);
    const double factor = *level / of_record;
    std::vector<std::string> overrides = of_wall;
    const std::vector<std::string> more = overrides_for(study.suite, record, motion, factor);
    overrides.insert(overrides.end(), more.begin(), more.end());
    ShakenRun run = shake(study, make_scene, overrides, place);
    run.factor = factor;
    for (std::size_t m = 0; m < kMeasures; ++m) run.intensity[m] = factor * motion.intensity[m];
    write_run(place, run);
    runs.push_back(run);
  }
  const bool failed = !runs.empty() && runs.back().failed();
  write_sample(folder, {failed ? "failed" : "done",
                        failed ? fmt::format("run {} with {} times the record: {}", runs.size(), runs.back().factor,
                                             runs.back().reason)
                               : "",
                        inputs_of(study, task), outputs_of(study.suite, runs)});
}

std::vector<ShakenRun> read_runs(const fs::path& folder) {
  std::vector<ShakenRun> runs;
  std::error_code unknown;
  for (fs::path file = folder_of(folder, 1) / "run.json"; fs::exists(file, unknown);
       file = folder_of(folder, runs.size() + 1) / "run.json")
    runs.push_back(read_run(file));
  return runs;
}

}  // namespace quoin::ensemble
