// Results of all ranks by one process after the other, so that none needs all of them (collect.cpp).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "step/simulation.h"

namespace quoin {

// Neighbouring blocks, contact points or joints, [first, end), some hundred or thousand, of which one rank has what
// results are made of. Runs follow each other in order.
struct ResultRun {
  std::int32_t first = 0, end = 0;
  int rank = 0;
};
std::vector<ResultRun> runs_of_blocks(const Simulation::Impl& s);
std::vector<ResultRun> runs_of_points(const Simulation::Impl& s);  // whole batches of their laws
std::vector<ResultRun> runs_of_joints(
    const Simulation::Impl& s);  // runs of joints on the lattice, with all of their points
bool brings(const Simulation::Impl& s, const ResultRun& run);  // this rank makes of it what rank 0 takes
// make: by the rank that has the run; take: by rank 0, in the order of runs. All ranks call it at the same moment: in
// on_frame, or after run(). Where rank 0 has all of the state it makes everything, and others do nothing.
void collect_at_first(const Simulation::Impl& s, std::span<const ResultRun> runs,
                      const std::function<std::string(const ResultRun&)>& make,
                      const std::function<void(const std::string&)>& take);
bool ranks_collect(const Simulation::Impl& s);               // false: one process, or rank 0 has all
double sum_brought(const Simulation::Impl& s, double here);  // of what each rank gives
double largest_brought(const Simulation::Impl& s, double here);
// So that rank 0 has all from now on. All ranks call it at the same moment.
void gather_at_first(Simulation::Impl& s);
// In order, those of joints that begin at a block of this rank.
void each_own_point(const Simulation::Impl& s, const std::function<void(std::int32_t)>& visit);
bool owns_block(const Simulation::Impl& s, int block);  // advances it; true: one process

}  // namespace quoin
