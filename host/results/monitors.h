// monitors.csv: what the monitors of a scene do, row by row of the history; monitors.json: the most of it, and its end.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "scene/read_monitors.h"
#include "step/simulation.h"

namespace quoin {

// Rows that an earlier process has written, up to a step. None: there is no such file.
std::vector<std::vector<double>> read_monitor_rows(const std::filesystem::path& folder, long last_step);

class MonitorFile {
 public:
  // before: rows of a run that this one goes on with. Throws Error(bad_input): a block that is not there.
  MonitorFile(const std::filesystem::path& folder, const Simulation& simulation, std::vector<Monitor> monitors,
              const std::vector<std::vector<double>>& before);
  // Throw Error(bad_input) where the files cannot be written.
  void add(const HistoryRow& row);
  void flush() { stream_.flush(); }  // before a checkpoint, whose rows must be on the disk
  void finish();

 private:
  struct Place {
    std::vector<std::pair<int, int>> gridpoint;  // block, and which of it; -1: the mean of all
    Vec3 start{};                                // m
  };
  struct Motion {
    Vec3 displacement{}, velocity{};  // m, m/s
  };
  void find_places();
  Motion motion_of(const Place& place) const;
  Motion ground_of(const HistoryRow& row) const;
  void write(const std::vector<double>& values);

  std::filesystem::path folder_;
  const Simulation& simulation_;
  std::vector<Monitor> monitors_;
  std::vector<Place> places_;
  const void* found_in_ = nullptr;  // kind of motion that the places were found in
  std::vector<std::string> columns_;
  std::vector<std::vector<double>> rows_;
  std::ofstream stream_;
};

}  // namespace quoin
