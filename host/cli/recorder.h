// Output of a run: files, terminal, and the page of a running simulation.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "cli/live_run.h"
#include "cli/progress.h"
#include "cli/resume.h"
#include "results/checkpoint_file.h"
#include "results/history.h"
#include "results/monitors.h"
#include "results/summary.h"
#include "results/surface.h"
#include "results/vtk.h"

namespace quoin {

// Observer that writes rows to the history, frames to VTK, progress to the terminal, and checkpoints.
class Recorder : public Observer {
 public:
  // before: records of the run that this one continues.
  Recorder(const std::filesystem::path& folder, const Simulation& simulation, Surfaces& surfaces, Identity identity,
           double checkpoint_every, const ResultsSoFar& before, bool compressed, Pieces pieces);

  void on_stage_begin(const Simulation& simulation, int stage) override;
  void on_law_swap(const LawSwap& swap) override;
  void on_warning(const Warning& warning) override;
  void on_promotion(const Simulation& simulation) override;
  void on_row(const HistoryRow& row) override;
  // Serves a page with the state of the run, from its start on.
  void serve(std::unique_ptr<PageServer> server, const std::filesystem::path& folder, const Simulation& simulation);
  void follow(const std::filesystem::path& folder, const Simulation& simulation,
              const std::vector<std::vector<double>>& before);
  void finish_tables();
  bool wants_pause(bool last) override { return clock_.due() || (last && clock_.on()); }
  void on_pause(const Simulation& simulation, bool) override;
  void on_progress(const Progress& progress) override;
  void on_frame(const Simulation& simulation, int, int) override;
  void on_stage_end(const Simulation& simulation, int stage, const HistoryRow& last) override;

  // Whether this process, or the one that it continues, has reported the warning.
  bool was_reported(const Warning& warning) const { return reported_.contains(warning.about); }
  History& history() { return history_; }
  const std::optional<MonitorFile>& monitors() const { return monitors_; }
  VtkSeries& frames() { return frames_; }
  const std::optional<Error>& frames_fault() const { return frames_fault_; }
  const std::vector<StageModes>& modes() const { return modes_; }
  ProgressLine& progress() { return progress_; }

 private:
  void take(const HistoryRow& row);
  // Share of contact points that are no longer in their initial state, elastic or dry.
  static double cracked_share(const Simulation& simulation);

  const Scene& scene_;
  Surfaces& surfaces_;
  History history_;
  std::optional<MonitorFile> monitors_;
  VtkSeries frames_;
  ProgressLine progress_;
  std::filesystem::path checkpoint_;
  Identity identity_;
  CheckpointClock clock_;
  RunSoFar so_far_;
  std::size_t stage_of_peak_ = 0;           // stage of the last row, whose curve has the peak so far
  const Simulation* simulation_ = nullptr;  // the simulation on the live page
  std::unique_ptr<LiveRun> live_;           // null: no live page
  std::set<std::string> reported_;
  std::vector<StageModes> modes_;  // modes of stages with ground motion
  std::optional<Error> frames_fault_;
};

}  // namespace quoin
