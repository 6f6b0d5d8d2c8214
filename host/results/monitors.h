// monitors.csv: motion of the monitors of a scene, in the rows of the history. monitors.json: its maxima and its end.
#pragma once

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

class MonitorFile {
 public:
  // before: rows of the run that this one continues. Throws Error(bad_input) for a block that does not exist.
  MonitorFile(const std::filesystem::path& folder, const Simulation& simulation,
              const std::vector<std::vector<double>>& before);
  // Throw Error(bad_input) where the files cannot be written.
  void add(const HistoryRow& row);
  void finish();
  const std::vector<std::vector<double>>& rows() const { return rows_; }

 private:
  struct Motion {
    Vec3 displacement{}, velocity{};  // m, m/s
  };
  void find_places();
  Motion motion_of(const MonitorPlace& place) const;
  Motion ground_of(const HistoryRow& row) const;
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
