#include "results/monitors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/index.h"
#include "files/csv_text.h"
#include "files/file.h"
#include "results/json_file.h"
#include "scene/generate_blocks.h"
#include "step/assembly.h"
#include "step/large_motion.h"
#include "step/results.h"

namespace quoin {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kAxes[] = {"x", "y", "z"};
constexpr std::size_t kHead = 2;                       // columns of step and time
constexpr std::size_t kOfGround = 9, kOfMonitor = 20;  // numbers of columns
constexpr std::size_t kRelative = 9, kDrift = 18;      // columns of a monitor: displacement on the ground, drifts

fs::path file_in(const fs::path& folder) { return folder / "monitors.csv"; }

// Adds the names of displacement, velocity, acceleration of one point, by component.
void name_motion(const std::string& prefix, std::vector<std::string>& columns) {
  for (const char* axis : kAxes) columns.push_back(fmt::format("{}_d{}_m", prefix, axis));
  for (const char* axis : kAxes) columns.push_back(fmt::format("{}_v{}_m_s", prefix, axis));
  for (const char* axis : kAxes) columns.push_back(fmt::format("{}_a{}_m_s2", prefix, axis));
}

}  // namespace

std::vector<MonitorPlace> monitor_places(const Simulation& simulation) {
  const blocks::Assembly shapes = assembly_of(simulation);
  const std::optional<BuildingSpec>& building = simulation.scene().building;
  std::vector<MonitorPlace> places;
  for (const Monitor& m : simulation.scene().monitors) {
    std::vector<int> blocks;
    for (const std::string& name : bodies_called(m.block, building.value_or(BuildingSpec{}))) {
      const std::vector<int> found = blocks::find_blocks(shapes, name, m.source.text);
      blocks.insert(blocks.end(), found.begin(), found.end());
    }
    MonitorPlace place;
    double nearest = HUGE_VAL, count = 0.0;
    Vec3 middle{};
    for (const int block : blocks) {
      const std::vector<Vec3> corners = block_mesh(simulation, block).gridpoint;
      if (!m.point) place.gridpoint.emplace_back(block, -1);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        middle += corners[i];
        count += 1.0;
        if (!m.point) continue;
        const double far =
            std::hypot(corners[i][0] - (*m.point)[0], corners[i][1] - (*m.point)[1], corners[i][2] - (*m.point)[2]);
        if (far >= nearest) continue;
        nearest = far, place.start = corners[i];
        place.gridpoint = {{block, static_cast<int>(i)}};
      }
    }
    if (!m.point) place.start = middle / count;
    for (std::size_t b = 0; b < places.size(); ++b) {
      constexpr double kRounding = 1e-9;  // m
      if (simulation.scene().monitors[b].name != m.below) continue;
      if (std::abs(places[b].start[1] - place.start[1]) > kRounding) continue;
      throw Error(Exit::bad_input,
                  fmt::format("{}: monitor {}: below = \"{}\", at the same height y = {:.6g} m; a drift needs monitors "
                              "at two heights",
                              m.source.text, m.name, m.below, place.start[1]));
    }
    places.push_back(std::move(place));
  }
  return places;
}

MonitorFile::MonitorFile(const fs::path& folder, const Simulation& simulation,
                         const std::vector<std::vector<double>>& before)
    : folder_(folder), simulation_(simulation), monitors_(simulation.scene().monitors), columns_{"step", "time_s"} {
  find_places();
  name_motion("ground", columns_);
  for (const Monitor& m : monitors_) {
    name_motion(m.name, columns_);
    name_motion(m.name + "_relative", columns_);
    for (const char* axis : {"x", "z"}) columns_.push_back(fmt::format("{}_drift_{}", m.name, axis));
  }
  stream_.open(begin_file(file_in(folder)), std::ios::trunc);
  for (std::size_t i = 0; i < columns_.size(); ++i) stream_ << (i == 0 ? "" : ",") << columns_[i];
  stream_ << '\n';
  for (const std::vector<double>& row : before) {
    if (row.size() != columns_.size()) throw Error(Exit::bad_input, "checkpoint: its rows of monitors are of others");
    write(row);
  }
}

// Called again after promotion to large motion, whose gridpoints have another order.
void MonitorFile::find_places() {
  found_in_ = simulation_.large_motion();
  places_ = monitor_places(simulation_);
}

MonitorFile::Motion MonitorFile::motion_of(const MonitorPlace& place) const {
  Motion mean;
  const auto add = [](const std::vector<Vec3>& of_points, int point, double share, Vec3& sum) {
    const std::size_t first = point < 0 ? 0 : at(point), end = point < 0 ? of_points.size() : first + 1;
    for (std::size_t i = first; i < end; ++i) sum += share * of_points[i] / static_cast<double>(end - first);
  };
  const double share = 1.0 / static_cast<double>(place.gridpoint.size());
  for (const auto& [block, point] : place.gridpoint) {
    add(block_displacement(simulation_, block), point, share, mean.displacement);
    add(block_velocity(simulation_, block), point, share, mean.velocity);
  }
  // Forces of a row belong to the positions one step ago.
  const double step = simulation_.time_step_report().time_step;
  mean.displacement -= step * mean.velocity;
  return mean;
}

// The velocity is that of a fixed block with the ground's displacement; without one, that of the ground below springs.
MonitorFile::Motion MonitorFile::ground_of(const HistoryRow& row) const {
  Motion ground{row.ground_displacement, {}};
  const blocks::Model* const model = simulation_.large_motion();
  for (int block = 0; block < static_cast<int>(simulation_.block_count()); ++block) {
    if (model ? !model->assembly.blocks[at(block)].fixed : !simulation_.assembly().bricks[at(block)].fixed) continue;
    const Motion of_block = motion_of({{{block, -1}}, {}});
    double apart = 0.0;
    for (std::size_t c = 0; c < 3; ++c) apart += std::abs(of_block.displacement[c] - ground.displacement[c]);
    constexpr double kRounding = 1e-9;  // m
    if (apart > kRounding) continue;
    ground.velocity = of_block.velocity;
    return ground;
  }
  for (std::size_t c = 0; model && c < 3; ++c) {
    const int k = static_cast<int>(c);
    ground.velocity[c] = 2.0 * model->actions.ground_now[k] - model->actions.ground_then[k];  // half a step later
  }
  return ground;
}

std::size_t MonitorFile::index_below(std::size_t monitor) const {
  std::size_t b = 0;
  while (b < monitor && monitors_[b].name != monitors_[monitor].below) ++b;
  return b;
}

void MonitorFile::add(const HistoryRow& row) {
  if (found_in_ != simulation_.large_motion()) find_places();
  std::vector<double> values{static_cast<double>(row.step), row.time};
  const std::vector<double>* const before = rows_.empty() ? nullptr : &rows_.back();
  const auto append = [&](const Vec3& of_axes) { values.insert(values.end(), of_axes.begin(), of_axes.end()); };
  // Acceleration: change of velocity since the row before, over the time between.
  const auto append_motion = [&](const Motion& motion) {
    append(motion.displacement);
    const std::size_t of_velocity = values.size();
    append(motion.velocity);
    Vec3 acceleration{kNone, kNone, kNone};
    for (std::size_t c = 0; c < 3 && before && row.time > (*before)[1]; ++c)
      acceleration[c] = (motion.velocity[c] - (*before)[of_velocity + c]) / (row.time - (*before)[1]);
    append(acceleration);
  };
  const Motion ground = ground_of(row);
  append_motion(ground);
  std::vector<Vec3> moved;
  for (std::size_t i = 0; i < monitors_.size(); ++i) {
    Motion motion = motion_of(places_[i]);
    moved.push_back(motion.displacement);
    append_motion(motion);
    motion.displacement -= ground.displacement, motion.velocity -= ground.velocity;
    append_motion(motion);
    const std::size_t b = index_below(i);
    const double height = places_[i].start[1] - places_[b].start[1];
    for (const std::size_t c : {std::size_t{0}, std::size_t{2}})
      values.push_back(b < i ? (moved[i][c] - moved[b][c]) / height : kNone);
  }
  write(values);
}

std::vector<StoreyDrift> MonitorFile::storey_drifts() const {
  std::vector<StoreyDrift> all;
  for (std::size_t i = 0; i < monitors_.size(); ++i) {
    const std::size_t b = index_below(i);
    if (b == i) continue;
    StoreyDrift storey{monitors_[i].name, monitors_[b].name, places_[b].start[1], places_[i].start[1], {}, {}};
    for (const std::vector<double>& row : rows_) {
      for (std::size_t c = 0; c < 2; ++c) {
        const double drift = row[kHead + kOfGround + i * kOfMonitor + kDrift + c];
        storey.least[c] = std::min(storey.least[c], drift), storey.most[c] = std::max(storey.most[c], drift);
      }
    }
    all.push_back(storey);
  }
  return all;
}

void MonitorFile::write(const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) stream_ << (i == 0 ? "" : ",") << csv_number(values[i]);
  stream_ << '\n';
  require_written();
  rows_.push_back(values);
}

void MonitorFile::require_written() {
  if (stream_) return;
  stream_.close();
  abandon_file(file_in(folder_));
  throw Error(Exit::bad_input,
              file_in(folder_).string() + ": cannot be written; free space, or choose another folder with --out");
}

void MonitorFile::finish() {
  stream_.close();
  require_written();
  finish_file(file_in(folder_));
  Json json = Json::object();
  for (std::size_t i = 0; i < monitors_.size(); ++i) {
    const std::size_t first = kHead + kOfGround + i * kOfMonitor;
    Json& of_monitor = json[monitors_[i].name];
    for (std::size_t k = 0; k < kOfMonitor; ++k) {
      double largest = 0.0;
      bool known = false;
      for (const std::vector<double>& row : rows_) {
        if (std::isfinite(row[first + k])) largest = std::max(largest, std::abs(row[first + k])), known = true;
      }
      if (known) of_monitor["largest"][columns_[first + k]] = largest;
    }
    // Residual values of displacements against the ground and of drifts.
    for (const std::size_t k : {kRelative, kRelative + 1, kRelative + 2, kDrift, kDrift + 1}) {
      if (!rows_.empty() && std::isfinite(rows_.back()[first + k]))
        of_monitor["residual"][columns_[first + k]] = rows_.back()[first + k];
    }
  }
  write_json(folder_ / "monitors.json", json);
}

}  // namespace quoin
