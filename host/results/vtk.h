// Fields for ParaView: blocks_NNNN.vtu, joints_NNNN.vtu and forces_NNNN.vtu (resultants, joint by joint), collected
// over time by blocks.pvd, joints.pvd and forces.pvd. Blocks have their places at the start; warped by displacement_m,
// their current places. Deformable blocks are zones, rigid ones faces. Members are lines and panels in their current
// places, in members_NNNN.vtu. Several ranks may write a frame together, each its own blocks. Rank 0 then writes
// blocks_NNNN.pvtu too, which lists the pieces blocks_NNNN_r0.vtu, blocks_NNNN_r1.vtu, ..., and joints_NNNN.pvtu.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "results/surface.h"
#include "step/simulation.h"

namespace quoin {

// Bytes of the files blocks and joints of one frame, to a few per cent.
double frame_bytes(const Simulation& simulation, const Surfaces& surfaces);

// Piece that this rank writes.
struct Pieces {
  int rank = 0, count = 1;
};

// Sends the data of a rank that writes no file, so that rank 0 can write the frame. add_frame and add_piece of rank 0
// wait for it.
void collect_frame(const Simulation& simulation, const Surfaces& surfaces);

class VtkSeries {
 public:
  // before: times of the frames of the run that this one continues, s.
  VtkSeries(std::filesystem::path folder, const Surfaces& surfaces, std::vector<double> before = {},
            bool compressed = false, Pieces pieces = {});
  void add_frame(const Simulation& simulation);  // writes the whole frame; other ranks call collect_frame
  void add_piece(const Simulation& simulation);  // collective; without pieces it writes the whole frame
  void leave_out(const Simulation& simulation);  // replaces add_piece on a rank that writes nothing: it sends data if
                                                 // rank 0 waits for them
  void finish() const;                           // writes the collections
  const std::vector<double>& times() const { return times_; }

 private:
  void add(const Simulation& simulation, bool piece);

  std::filesystem::path folder_;
  const Surfaces& surfaces_;
  std::vector<double> times_;
  bool compressed_;
  Pieces pieces_;
};

}  // namespace quoin
