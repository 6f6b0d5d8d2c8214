// Progress on stderr: a bar that is redrawn on a terminal, a line now and then otherwise.
#pragma once

#include <chrono>
#include <string>

#include "step/simulation.h"

namespace quoin {

// What a run has come to.
struct RunSoFar {
  double displacement = 0.0, force = 0.0;         // m, N
  double peak = 0.0, displacement_at_peak = 0.0;  // N, m
  double cracked = 0.0;                           // share of contact points that are no longer elastic
  double kinetic_energy = 0.0;                    // J
};

class ProgressLine {
 public:
  ProgressLine();
  void show(const Progress& progress, const RunSoFar& so_far);
  void message(const std::string& text);  // a line of its own, above the bar

 private:
  void clear();
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
  int last_stage_ = -1;
};

// "time: law 31 %, ..., set-up and the rest 4 %": where `whole` seconds of a run have gone. Phases below half a percent
// are left out.
std::string phases_text(const PhaseTimes& times, double whole);

// "ranks: 2; a rank and step 13.2 kB in 1 message; waiting 4.1 %, ...": what running on several processes has cost.
std::string ranks_text(const std::vector<RankTraffic>& ranks);

}  // namespace quoin
