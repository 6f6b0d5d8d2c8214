// What a run has found out of itself: how far blocks have moved, what holds them, where time went.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

const MotionSeen& motion_seen(const Simulation::Impl& s);  // motion at the last check of run()
const Watch& watch_of(const Simulation::Impl& s);          // at the last row
double allowed_overlap(const Simulation::Impl& s);         // m
std::string past_motion_bound(const Simulation::Impl& s);  // bound that is exceeded, and where; empty: none
// The contact points of a batch, for messages, from any thread: "contact points 0 to 255 of joint family
// 'mortar', from (0.100, 0.000, 0.050) m on".
std::string batch_text(const Simulation::Impl& s, const quoin_batch& batch);

// What a stage holds or drives, "base: x y z" each. And the blocks that no joint of the start ties to anything that
// is held against gravity.
struct Supports {
  std::vector<std::string> held;
  std::vector<int> loose;
};
Supports supports_in(const Simulation::Impl& s, int stage);
std::string block_label(const Simulation::Impl& s, int block);  // as messages call it
// Those with columns in the history; empty where there are more than it can.
const std::vector<Restraint>& restraints_of(const Simulation::Impl& s);

// Time by phase since time_phases(), of every step; else of one step in kTimedSteps, taken so many times. On the
// lattice internal forces and motion are one kernel, whose time is that of motion.
void time_phases(Simulation::Impl& s);
const PhaseTimes& phase_times(const Simulation::Impl& s);
const std::vector<RankTraffic>& rank_traffic(const Simulation::Impl& s);  // by rank, of run(); empty: one process
bool ranks_together(const Simulation::Impl& s);  // false: run() has failed on some ranks and not on others

}  // namespace quoin
