// Findings of a run: how far blocks have moved, what supports them, and times of phases.
#pragma once

#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

const MotionSeen& motion_seen(const Simulation::Impl& s);  // at the last check of run()
const Watch& watch_of(const Simulation::Impl& s);          // at the last row
double allowed_overlap(const Simulation::Impl& s);         // closure of a contact point above which Watch warns, m
std::string past_motion_bound(const Simulation::Impl& s);  // bound that is exceeded, and where; empty: none
// Place of the contact points of a batch, for messages; thread-safe: "contact points 0 to 255 of joint family 'mortar',
// from (0.100, 0.000, 0.050) m on".
std::string batch_text(const Simulation::Impl& s, const quoin_batch& batch);

// Supports of a stage: held or driven blocks, each as "base: x y z". loose: blocks without a path of joints to a block
// that is held against gravity.
struct Supports {
  std::vector<std::string> held;
  std::vector<int> loose;
};
Supports supports_in(const Simulation::Impl& s, int stage);
std::string block_label(const Simulation::Impl& s, int block);  // name of a block in messages
// Restraints with columns in the history; empty where there are more than kMostRestraints.
const std::vector<Restraint>& restraints_of(const Simulation::Impl& s);

// Times by phase. After time_phases() every step is timed, else one in kTimedSteps, whose time is multiplied by that
// number. On the lattice internal forces are part of the time of motion, as one kernel computes both.
void time_phases(Simulation::Impl& s);
const PhaseTimes& phase_times(const Simulation::Impl& s);
const std::vector<RankTraffic>& rank_traffic(const Simulation::Impl& s);  // of run(), by rank; empty: one process
bool ranks_together(const Simulation::Impl& s);  // false: run() has failed on some ranks and not on others

}  // namespace quoin
