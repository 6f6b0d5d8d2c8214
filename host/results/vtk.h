// Fields for ParaView: blocks_NNNN.vtu, joints_NNNN.vtu and forces_NNNN.vtu (resultants, joint by joint), collected
// over time by blocks.pvd, joints.pvd and forces.pvd. Blocks
// are drawn where they were at the start; warped by displacement_m, where they stand. Deformable ones are zones, rigid
// ones faces. Members are lines and panels where they stand, in members_NNNN.vtu. Several processes may write a frame
// together, each the blocks that it advances. Rank 0 then writes blocks_NNNN.pvtu too, which names the pieces
// blocks_NNNN_r0.vtu, blocks_NNNN_r1.vtu, ..., and so for joints.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

// Bytes of one frame of both, to a few per cent.
double frame_bytes(const Simulation& simulation, const Surfaces& surfaces);

// Which of them this process writes.
struct Pieces {
  int rank = 0, count = 1;
};

// What a rank does that writes no file, so that rank 0 can write the frame: its add_frame or add_piece waits for that.
void collect_frame(const Simulation& simulation, const Surfaces& surfaces);

class VtkSeries {
 public:
  // before: times of the frames of a run that this one goes on with, s.
  VtkSeries(std::filesystem::path folder, const Surfaces& surfaces, std::vector<double> before = {},
            bool compressed = false, Pieces pieces = {});
  void add_frame(const Simulation& simulation);  // all of it; other ranks call collect_frame
  void add_piece(const Simulation& simulation);  // by all ranks; where there are no pieces: all of it
  void leave_out(const Simulation& simulation);  // in place of add_piece: other ranks write theirs, or wait for no one
  void finish() const;                           // writes the collections
  const std::vector<double>& times() const { return times_; }

 private:
  void add(const Simulation& simulation, bool piece);
  // The folder of results is rank 0's, which notes beforehand what is written there. It does so one frame ahead, as no
  // rank comes to the next frame before all have written this one.
  void note_pieces() const;

  std::filesystem::path folder_;
  const Surfaces& surfaces_;
  std::vector<double> times_;
  bool compressed_;
  Pieces pieces_;
};

}  // namespace quoin
