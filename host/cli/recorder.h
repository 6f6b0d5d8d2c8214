// What a run reports goes to its files, to the terminal and to the page of a run that goes on.
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

// Takes what the simulation reports: rows to the history, frames to VTK, progress to the terminal; and checkpoints.
class Recorder : public Observer {
 public:
  // before: what the run that goes on has recorded.
  Recorder(const std::filesystem::path& folder, const Simulation& simulation, Surfaces& surfaces, Identity identity,
           double checkpoint_every, const Checkpoint& before, bool compressed, Pieces pieces);

  void on_stage_begin(const Simulation& simulation, int stage) override;
  void on_law_swap(const LawSwap& swap) override;
  void on_warning(const Warning& warning) override;
  void on_promotion(const Simulation& simulation) override;
  void on_row(const HistoryRow& row) override;
  // Shows the run while it goes on: what it has come to so far, and from now on.
  void serve(int port, const std::filesystem::path& folder, const Simulation& simulation);
  void follow(const std::filesystem::path& folder, const Simulation& simulation, std::vector<Monitor> monitors,
              const std::vector<std::vector<double>>& before);
  void finish_tables();
  bool wants_pause(bool last) override { return clock_.due() || (last && clock_.on()); }
  void on_pause(const Simulation& simulation, bool) override;
  void on_progress(const Progress& progress) override;
  void on_frame(const Simulation& simulation, int, int) override;
  void on_stage_end(const Simulation& simulation, int stage, const HistoryRow& last) override;

  // By this process, or by the one that it goes on from.
  bool was_reported(const Warning& warning) const { return reported_.contains(warning.about); }
  History& history() { return history_; }
  VtkSeries& frames() { return frames_; }
  const std::optional<Error>& frames_fault() const { return frames_fault_; }
  const std::vector<StageModes>& modes() const { return modes_; }
  ProgressLine& progress() { return progress_; }

 private:
  void take(const HistoryRow& row);
  // Share of contact points that are not in their first state, elastic or dry.
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
  const Simulation* simulation_ = nullptr;  // that is served
  std::unique_ptr<LiveRun> live_;           // null: no live page
  std::set<std::string> reported_;
  std::vector<StageModes> modes_;  // modes of stages that move the ground
  std::optional<Error> frames_fault_;
};

}  // namespace quoin
