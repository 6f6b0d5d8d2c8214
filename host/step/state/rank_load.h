// How much each rank works and waits, and when blocks are divided again because of it. Written in each step, and at the
// end of a run.
#pragma once

#include <optional>
#include <vector>

#include "step/rank_balance.h"
#include "step/simulation.h"
#include "step/state/step_timing.h"

namespace quoin {

// Steps of this rank since the last check of how even the ranks are.
struct RankWindow {
  long steps = 0;
  double seconds_before = 0.0;    // RankTraffic::own_seconds when it began
  std::vector<double> estimated;  // by rank, the costs of its steps
};

// Tests cannot wait for costs that differ. QUOIN_DEAR_BLOCKS=20x4: clocks say that each of the first 20 blocks costs
// four times as much as it is estimated to, and that dividing is free.
struct CostlyBlocks {
  int count = 0;
  double times = 1.0;
};

struct RankLoad {
  Clock::time_point run_start = Clock::now();
  RankTraffic traffic;  // traffic of this rank
  std::vector<RankTraffic> traffic_of_all;
  RankBalance balance;
  RankWindow window;
  std::vector<double> measured_over_estimated;  // cost by block; empty: nothing is known yet
  std::optional<CostlyBlocks> costly_blocks;    // costs for tests
};

}  // namespace quoin
