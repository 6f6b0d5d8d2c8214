// Columns that a scene adds to the history beside HistoryNumbers. A group of them is one file of this folder, and its
// name in columns.cpp.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

struct ColumnGroup {
  // As history.csv has them, with their units; empty: the scene has none.
  std::vector<std::string> (*names)(const Scene& scene);
  // As many numbers, when a row is taken after a step, at the time of the forces of that step. Without a value: NaN.
  std::vector<double> (*values)(const Simulation::Impl& run);
};

// Columns of all groups, in the order of the file.
std::vector<std::string> added_columns(const Scene& scene);
std::vector<double> added_values(const Simulation::Impl& run);

}  // namespace quoin
