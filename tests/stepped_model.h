// A model of blocks in large motion with a loop of its own, for tests without stages and output. Its bits are those of
// Simulation (BlockThreads.TheModelsLoopIsThatOfASimulation).
#pragma once

#include "base/thread_pool.h"
#include "step/large_motion.h"

namespace quoin {

struct SteppedModel : blocks::Model {
  using Model::Model;

  ThreadPool* threads = nullptr;  // of the loop; null: the caller alone

  // One step. Throws Error(numerical): the law failed at a point, or the position of a block is not finite.
  void step() {
    pool = threads;
    begin_step(true);
    each_part(pool, static_cast<std::size_t>(chunk_count()), 1,
              [this](std::size_t chunk, std::size_t) { advance_contacts(static_cast<int>(chunk)); });
    each_part(pool, static_cast<std::size_t>(piece_count()), 1,
              [this](std::size_t piece, std::size_t) { advance_piece(static_cast<int>(piece)); });
    if (end_step()) find_contacts();
  }
  void run(double duration) {  // s
    const double end = stepping.time + duration;
    while (stepping.time < end - 0.5 * stepping.dt) step();
  }
};

}  // namespace quoin
