// The last lines of a run on the terminal.
#pragma once

#include <filesystem>
#include <vector>

#include "results/summary.h"
#include "step/simulation.h"

namespace quoin {

void print_results(const std::filesystem::path& folder, const Simulation& simulation,
                   const std::vector<HistoryRow>& rows, const RunInfo& info);

}  // namespace quoin
