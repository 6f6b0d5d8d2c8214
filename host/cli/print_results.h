// The last lines of a run on the terminal.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/report.h"
#include "results/summary.h"
#include "step/simulation.h"

namespace quoin {

void print_results(const std::filesystem::path& folder, const Simulation& simulation,
                   const std::vector<HistoryRow>& rows, const RunInfo& info);

// Writes report.html beside a file of motions, and prints its path; a notice without three.js, as ParaView shows them.
void print_motion_report(const std::filesystem::path& vtu, const std::string& what, const Scene& scene,
                         const std::vector<ShownMotion>& motions, bool one_way);

}  // namespace quoin
