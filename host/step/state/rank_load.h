// Work and waiting times of ranks, for load balancing. Written in each step and at the end of a run.
#pragma once

#include <optional>
#include <vector>

#include "step/rank_balance.h"
#include "step/simulation.h"
#include "step/state/step_timing.h"

namespace quoin {

// Steps of this rank since load balancing was last checked.
struct RankWindow {
  long steps = 0;
  double seconds_before = 0.0;    // RankTraffic::own_seconds at its beginning
  std::vector<double> estimated;  // estimated cost of these steps by rank, any unit
};

// Costs for tests, which cannot wait for real ones to differ. QUOIN_DEAR_BLOCKS=20x4: each of the first 20 blocks costs
// four times its estimate, and a repartition costs nothing.
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
  std::vector<double> measured_over_estimated;  // by block; empty: not measured yet
  std::optional<CostlyBlocks> costly_blocks;    // for tests
};

}  // namespace quoin
