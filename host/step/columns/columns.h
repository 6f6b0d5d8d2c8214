// Columns that a scene adds to the history beside HistoryNumbers. A group of them is a file of this folder, with its
// name in columns.cpp.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

struct ColumnGroup {
  // Names in history.csv, with units; empty: the scene has none of the group.
  std::vector<std::string> (*names)(const Scene& scene);
  // One number a name, for a row after a step, at the time of the forces of that step. NaN: no value.
  std::vector<double> (*values)(const Simulation::Impl& run);
};

// Columns of all groups, in the order of history.csv.
std::vector<std::string> added_columns(const Scene& scene);
std::vector<double> added_values(const Simulation::Impl& run);

}  // namespace quoin
