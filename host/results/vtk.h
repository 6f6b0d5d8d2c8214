// Fields for ParaView: blocks_NNNN.vtu and joints_NNNN.vtu, collected over time by blocks.pvd and joints.pvd. Blocks
// are drawn where they were at the start; warped by displacement_m, where they stand. Deformable ones are zones, rigid
// ones faces.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

// Bytes of one frame of both, to a few per cent.
double frame_bytes(const Simulation& simulation, const Surfaces& surfaces);

class VtkSeries {
 public:
  // before: times of the frames of a run that this one goes on with, s.
  VtkSeries(std::filesystem::path folder, const Surfaces& surfaces, std::vector<double> before = {},
            bool compressed = false)
      : folder_(std::move(folder)), surfaces_(surfaces), times_(std::move(before)), compressed_(compressed) {}
  void add_frame(const Simulation& simulation);
  void finish() const;  // writes the collections
  const std::vector<double>& times() const { return times_; }

 private:
  std::filesystem::path folder_;
  const Surfaces& surfaces_;
  std::vector<double> times_;
  bool compressed_;
};

}  // namespace quoin
