#include "step/rank_load.h"

#include <sys/resource.h>

#include <algorithm>

#include "base/rank_rows.h"
#include "step/findings.h"
#include "step/gather.h"
#include "step/rank_agreement.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Scales the costs of all blocks of a rank by its measured over estimated work: work is not measured by block.
void repartition(Simulation::Impl& s) {
  const auto before = Clock::now();
  if (!s.parts.divided) gather(s, Part::all);
  const std::vector<double> of_rank = s.rank_load.balance.measured_over_estimated();
  s.rank_load.measured_over_estimated.resize(
      s.large_motion ? at(s.large_motion->block_count()) : s.model.assembly.bricks.size(), 1.0);
  for (int item = 0; item < static_cast<int>(s.division.share.rank_of_item.size()); ++item) {
    for (const int b : blocks_of_item(s, item))
      s.rank_load.measured_over_estimated[at(b)] *= of_rank[at(s.division.share.rank_of_item[at(item)])];
  }
  const std::vector<int> before_it = s.division.share.rank_of_item;
  if (s.parts.divided && !s.large_motion) {
    const RankShare next = share_of_this_rank(s);
    gather(s, Part::all, Who::holders, &next);
  }
  partition_work(s);
  s.controls.rest_known = false;                     // at_rest of bodies from other ranks is unknown
  if (s.division.share.rank_of_item != before_it) {  // else items are too large for a better partition
    if (s.rank_load.traffic.repartitions == 0.0) s.rank_load.traffic.uneven_before = s.rank_load.traffic.uneven;
    s.rank_load.traffic.repartitions += 1.0;
  }
  const double took = largest_of_ranks(s, seconds_since(before));
  s.rank_load.balance.divided(s.rank_load.costly_blocks ? 0.0 : took);
}

// Work of this rank in the window by costly_blocks, any unit.
double pretended_seconds(const Simulation::Impl& s) {
  const std::vector<double> cost = estimated_costs(s);
  double sum = 0.0;
  for (const int item : s.division.share.items) {
    const std::vector<int> blocks = blocks_of_item(s, item);
    const auto costly =
        std::count_if(blocks.begin(), blocks.end(), [&](int b) { return b < s.rank_load.costly_blocks->count; });
    const double part = static_cast<double>(costly) / static_cast<double>(blocks.size());
    sum += cost[at(item)] * (1.0 + (s.rank_load.costly_blocks->times - 1.0) * part);
  }
  return sum * static_cast<double>(s.rank_load.window.steps);
}

}  // namespace

const std::vector<RankTraffic>& rank_traffic(const Simulation::Impl& s) { return s.rank_load.traffic_of_all; }

void balance_ranks(Simulation::Impl& s) {
  if (!s.ranks || ++s.rank_load.window.steps < RankBalance::kWindow) return;
  const double own = s.rank_load.costly_blocks ? pretended_seconds(s)
                                               : s.rank_load.traffic.own_seconds - s.rank_load.window.seconds_before;
  const std::vector<double> seconds = of_all_ranks(*s.ranks, own);
  const bool worth = s.rank_load.balance.is_worth_dividing(seconds, s.rank_load.window.estimated);
  s.rank_load.traffic.uneven = most_over_mean(seconds);
  if (worth) repartition(s);
  s.rank_load.window = {0, s.rank_load.traffic.own_seconds, {}};
}

void collect_traffic(Simulation::Impl& s) {
  if (!s.ranks) return;
  s.rank_load.traffic.step_seconds = seconds_since(s.rank_load.run_start);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  s.rank_load.traffic.peak_memory = 1024.0 * static_cast<double>(usage.ru_maxrss);
  s.rank_load.traffic_of_all = of_all_ranks(*s.ranks, s.rank_load.traffic);
}

}  // namespace quoin
