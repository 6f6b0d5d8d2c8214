// A run that goes on, in a browser: `quoin run --serve`.
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "cli/page_server.h"
#include "cli/progress.h"
#include "results/history.h"
#include "results/report.h"

namespace quoin {

class LiveRun {
 public:
  // before: rows and times of frames of the run that this one goes on with. Throws as PageServer and
  // require_report_library.
  LiveRun(int port, const std::filesystem::path& folder, const Simulation& simulation,
          const std::vector<HistoryRow>& before, std::vector<double> frame_times);
  std::string address() const;
  // By the thread that runs.
  void add_row(const HistoryRow& row);
  void add_frame(const Simulation& simulation, const std::vector<HistoryRow>& rows);  // whose files are there
  void show(const Progress& progress, const RunSoFar& so_far);

 private:
  PageAnswer state();
  PageAnswer run();

  std::mutex mutex_;  // guards all that follows, but for what the server alone has
  const Scene& scene_;
  std::vector<HistoryColumn> columns_;
  std::vector<HistoryRow> rows_;
  std::vector<double> times_;
  std::string summary_, state_;
  GrowingRun growing_;  // run as the server has sent it so far
  std::unique_ptr<PageServer> server_;
};

}  // namespace quoin
