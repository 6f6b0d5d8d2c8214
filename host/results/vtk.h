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
  // before: times of the frames of a run that this one goes on with, s.
  VtkSeries(std::filesystem::path folder, const Surfaces& surfaces, std::vector<double> before = {})
      : folder_(std::move(folder)), surfaces_(surfaces), times_(std::move(before)) {}
  void add_frame(const Simulation& simulation);
  void finish(const Simulation& simulation) const;  // writes the collections
  const std::vector<double>& times() const { return times_; }

 private:
  std::filesystem::path folder_;
  const Surfaces& surfaces_;
  std::vector<double> times_;
};

}  // namespace quoin
