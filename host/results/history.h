// history.csv: one row per recorded step, SI units, named in the header.
#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// A row as people plot it: the wall's horizontal response, and what presses it.
struct Response {
  double displacement = 0.0;      // horizontal, of the monitor body since the start, m
  double horizontal_force = 0.0;  // resistance positive, N
  double vertical_force = 0.0;    // compression positive, N
};
Response response(const HistoryRow& row, const Stage& stage);

// 0, 1, 2: what a stage is measured along, or else driven along and nowhere else. It is 2, too, where the ground or the
// load of a collapse has z as its only horizontal direction.
int axis_of(const Stage& stage);
// Measured along y, or driven along y and nowhere else. Where the last stage is, what is shown of the run is upright.
bool is_vertical(const Stage& stage);
bool is_vertical(const Scene& scene);
// The quantities that show a stage: "push" (force against displacement of what is driven), "collapse" (multiplier),
// "earthquake" (over time) or "rest" (nothing is driven).
const char* curve_kind(const Stage& stage);
// What peak, pictures, page and screen show of a row.
struct Shown {
  double displacement = 0.0;  // displacement of the monitor body since the start, m
  double force = 0.0;         // resistance positive, N
};
Shown shown(const HistoryRow& row, const Scene& scene);

// A column of the history. value: of numbers and integers (exact); texts are the name of the stage.
struct HistoryColumn {
  enum class Kind { integer, text, number };
  std::string name;
  Kind kind;
  std::function<double(const HistoryRow& row, const Stage& stage)> value;
};
// In the order of the file.
std::vector<HistoryColumn> history_columns(const Scene& scene, const std::vector<Restraint>& restraints);

class History {
 public:
  // Rows go to the partial file of PATH (file.h) as they come, which finish() renames. before: rows of a run that this
  // one goes on with.
  History(const std::filesystem::path& path, const Simulation& simulation, const std::vector<HistoryRow>& before = {});
  // Both throw Error(bad_input) where the file cannot be written.
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
