// monitors.csv: motion of the monitors of a scene, in the rows of the history. monitors.json: its maxima and its end.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Where a monitor measures.
struct MonitorPlace {
  std::vector<std::pair<int, int>> gridpoint;  // block and gridpoint; -1: mean of all
  Vec3 start{};                                // m
};

// By monitor of the scene. Throws Error(bad_input) for a block that does not exist.
std::vector<MonitorPlace> monitor_places(const Simulation& simulation);

// Extremes of the drift between a monitor and the one below it.
struct StoreyDrift {
  std::string name, below;
  double bottom = 0.0, top = 0.0;         // heights of both at the start, m
  std::array<double, 2> least{}, most{};  // along x and z
};

class MonitorFile {
 public:
  // before: rows of the run that this one continues. Throws Error(bad_input) for a block that does not exist.
  MonitorFile(const std::filesystem::path& folder, const Simulation& simulation,
              const std::vector<std::vector<double>>& before);
  // Throw Error(bad_input) where the files cannot be written.
  void add(const HistoryRow& row);
  void finish();
  const std::vector<std::vector<double>>& rows() const { return rows_; }
  std::vector<StoreyDrift> storey_drifts() const;  // of the rows so far, in the order of the monitors

 private:
  struct Motion {
    Vec3 displacement{}, velocity{};  // m, m/s
  };
  void find_places();
  Motion motion_of(const MonitorPlace& place) const;
  Motion ground_of(const HistoryRow& row) const;
  std::size_t index_below(std::size_t monitor) const;  // monitor itself: none
  void write(const std::vector<double>& values);
  void require_written();  // throws Error(bad_input), and removes the unfinished file

  std::filesystem::path folder_;
  const Simulation& simulation_;
  const std::vector<Monitor>& monitors_;
  std::vector<MonitorPlace> places_;
  const void* found_in_ = nullptr;  // model in which the places were found
  std::vector<std::string> columns_;
  std::vector<std::vector<double>> rows_;
  std::ofstream stream_;
};

}  // namespace quoin
