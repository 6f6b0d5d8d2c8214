// Page of a running simulation in a browser: `quoin run --serve`.
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
  // before: rows of the run that this one continues. frame_times: of its frames, s. Throws as
  // require_report_library.
  LiveRun(std::unique_ptr<PageServer> server, const std::filesystem::path& folder, const Simulation& simulation,
          const std::vector<HistoryRow>& before, std::vector<double> frame_times);
  std::string address() const;
  // Called by the thread of the run:
  void add_row(const HistoryRow& row);
  void add_frame(const Simulation& simulation, const std::vector<HistoryRow>& rows);  // after its files are written
  void show(const Progress& progress, const RunSoFar& so_far);

 private:
  PageAnswer state();
  PageAnswer run();

  std::mutex mutex_;  // guards all members below, except those of the server's thread
  const Scene& scene_;
  std::vector<HistoryColumn> columns_;
  std::vector<HistoryRow> rows_;
  std::vector<double> times_;
  std::string summary_, state_;
  GrowingRun growing_;  // run as far as the server has sent it
  std::unique_ptr<PageServer> server_;
};

}  // namespace quoin
