// Results of all ranks, run by run on rank 0: no process needs memory for all of them (collect.cpp).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Some hundred or thousand consecutive blocks, contact points or joints, [first, end), whose results one rank makes.
// Runs are consecutive.
struct ResultRun {
  std::int32_t first = 0, end = 0;
  int rank = 0;
};
std::vector<ResultRun> runs_of_blocks(const Simulation::Impl& s);
std::vector<ResultRun> runs_of_points(const Simulation::Impl& s);  // of whole law batches
// Runs of joints on the lattice, with all points of each.
std::vector<ResultRun> runs_of_joints(const Simulation::Impl& s);
bool brings(const Simulation::Impl& s, const ResultRun& run);  // whether this rank makes its results
// Collects results on rank 0. make: called on the rank that has the run. take: on rank 0, in the order of runs. A
// single process calls both from any of its threads: make for several runs at once, and during take. All ranks call
// this at the same step: in on_frame, or after run(). Where rank 0 holds all of the state, it makes all results, and
// other ranks do nothing.
void collect_at_first(const Simulation::Impl& s, std::span<const ResultRun> runs,
                      const std::function<std::string(const ResultRun&)>& make,
                      const std::function<void(const std::string&)>& take);
bool ranks_collect(const Simulation::Impl& s);               // false: one process, or rank 0 holds all
double sum_brought(const Simulation::Impl& s, double here);  // sum over ranks; here: this rank's part
double largest_brought(const Simulation::Impl& s, double here);
// Gathers all of the state on rank 0. All ranks call it at the same step.
void gather_at_first(Simulation::Impl& s);
// Visits, in order, the contact points whose joints begin at a block of this rank.
void each_own_point(const Simulation::Impl& s, const std::function<void(std::int32_t)>& visit);
bool owns_block(const Simulation::Impl& s, int block);  // whether this rank advances it; true: one process

}  // namespace quoin
