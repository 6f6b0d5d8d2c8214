// Fields for ParaView: blocks_NNNN.vtu and joints_NNNN.vtu, collected over time by blocks.pvd and joints.pvd. Blocks of
// any shape are faces where they stand, blocks_NNNN.vtp.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

class VtkSeries {
 public:
  VtkSeries(std::filesystem::path folder, const Surfaces& surfaces) : folder_(std::move(folder)), surfaces_(surfaces) {}
  void add_frame(const Simulation& simulation);
  void finish() const;  // writes the collections

 private:
  std::filesystem::path folder_;
  const Surfaces& surfaces_;
  std::vector<double> times_;
  const char* of_blocks_ = "vtu";  // extension
};

}  // namespace quoin
