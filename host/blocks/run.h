// Runs the stages of a block scene.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "blocks/model.h"
#include "scene/block_scene.h"

namespace quoin::blocks {

struct Row {
  int stage = 0;
  long step = 0;
  double time = 0.0;                  // s
  double multiplier = 0.0;            // of the body force in a collapse stage
  Vector displacement;                // of the monitor block since the start, m
  Vector force;                       // of the contacts on the monitor block, N
  double largest_displacement = 0.0;  // of any block since the start, m
  double unbalanced_ratio = 0.0;
  Energies energies;
};

struct Outcome {
  std::optional<double> collapse_multiplier;
  std::optional<double> base_slip_at_uplift;  // m: of blocks on fixed ones, when a bed joint first opens by 0.1 mm
};

class Run {
 public:
  explicit Run(BlockScene scene);
  // row: after every record interval; frame: scene.frames times over the last stage, and at the end. Throws
  // Error(numerical), and Error(interrupted) after stop().
  Outcome run(const std::function<void(const Row&)>& row, const std::function<void(int frame)>& frame);
  void stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  const BlockScene& scene() const { return scene_; }
  const Model& model() const { return *model_; }
  Vector start_position(int block) const { return start_[block]; }
  double largest_displacement() const;
  Row measure(int stage) const;  // throws Error(numerical): a value that is not finite

 private:
  void begin(const BlockStage& stage, const BlockStage* previous);
  void run_stage(int index, const std::function<void(const Row&)>& row, const std::function<void(int)>& frame);
  void watch_uplift();

  BlockScene scene_;
  std::unique_ptr<Model> model_;
  std::vector<Vector> start_;
  std::vector<int> on_base_;  // free blocks that rest on fixed ones at the start
  int monitor_ = -1;
  double multiplier_ = 0.0, stage_start_ = 0.0;
  Outcome outcome_;
  std::atomic<bool> stop_{false};
};

}  // namespace quoin::blocks
