// history.csv: one row per recorded step, SI units, named in the header.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Response for plots: horizontal force and displacement, and vertical force.
struct Response {
  double displacement = 0.0;      // horizontal, of the monitor body since the start, m
  double horizontal_force = 0.0;  // resistance positive, N
  double vertical_force = 0.0;    // compression positive, N
};
Response response(const HistoryRow& row, const Stage& stage);

// Axis of a stage's displacement: 0, 1, 2. It is the axis of its criterion, or else the only one along which it drives
// a body. It is 2, too, where the ground or the load of a collapse has z as its only horizontal direction.
int axis_of(const Stage& stage);
// First axis of x, z, y along which the ground moves or a collapse pushes; 0 without either.
int axis_of_action(const Stage& stage);
// Direction of length 1 along which the response to ground motion is measured.
struct ResponseAxis {
  Vec3 direction{1.0, 0.0, 0.0};
  std::string name = "x";  // y, z, or as "(0.6, 0, 0.8)"
};
// Axis z where the stage is measured along it, else the horizontal part of the strongest horizontal motion; without one
// that of the vertical.
ResponseAxis response_axis(const Stage& stage);
// Axis or direction of the curve of a stage: that of the response to ground motion, or of axis_of.
std::string axis_name(const Stage& stage);
// Whether a stage has no monitor: rows have no displacement and no force of one.
bool watches_nothing(const Scene& scene, const Stage& stage);
// Key that gives a monitor, for messages.
const char* key_of_monitor(const Scene& scene);
// Whether rows have the columns of blocks and of actions: of any shape, or some stage goes beyond the lattice.
bool has_actions(const Scene& scene);
// Whether a stage is measured along y, or drives bodies along y alone. A run is vertical if the stage of its curve is.
bool is_vertical(const Stage& stage);
bool is_vertical(const Scene& scene);
// Kind of curve of a stage: "push" (force against displacement of the driven part), "collapse" (multiplier),
// "earthquake" (over time) or "rest" (nothing is driven).
const char* curve_kind(const Stage& stage);
// Displacement and force of a row in peak, pictures, page and screen.
struct Shown {
  double displacement = 0.0;  // displacement of the monitor body since the start, m
  double force = 0.0;         // resistance positive, N
};
Shown shown(const HistoryRow& row, const Scene& scene);

// A column of the history. value: number, or exact integer; the column of kind text is the stage's name.
struct HistoryColumn {
  enum class Kind { integer, text, number };
  std::string name;
  Kind kind;
  std::function<double(const HistoryRow& row, const Stage& stage)> value;
};
// Columns in the order of the file.
std::vector<HistoryColumn> history_columns(const Scene& scene, const std::vector<Restraint>& restraints);

// Energy that was dissipated, J.
struct DissipatedEnergy {
  double damping = 0.0, members = 0.0, joints = 0.0;
  double all() const { return damping + members + joints; }
};
// In the stages that move the ground. Stages of settling before them do not count. Rows must have energies.
DissipatedEnergy dissipated_in_earthquake(const std::vector<HistoryRow>& rows, const Scene& scene);

class History {
 public:
  // Appends rows to the partial file of `path` (file.h), which finish() renames. before: rows of the run that this one
  // continues.
  History(const std::filesystem::path& path, const Simulation& simulation, const std::vector<HistoryRow>& before = {});
  // Both throw Error(bad_input) when the file cannot be written.
  void add(const HistoryRow& row);
  void finish();
  const std::vector<HistoryRow>& rows() const { return rows_; }

 private:
  [[noreturn]] void refuse();
  std::filesystem::path path_;
  const Scene& scene_;
  std::vector<HistoryColumn> columns_;
  std::ofstream stream_;
  std::vector<HistoryRow> rows_;
};

}  // namespace quoin
