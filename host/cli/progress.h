// Progress on stderr: a bar on a terminal, otherwise a line every few seconds.
#pragma once

#include <chrono>
#include <string>

#include "step/simulation.h"

namespace quoin {

// Present state of a run.
struct RunSoFar {
  double displacement = 0.0, force = 0.0;         // m, N
  double peak = 0.0, displacement_at_peak = 0.0;  // N, m
  double cracked = 0.0;                           // share of contact points that are not elastic any more
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

// "time: law 31 %, ..., set-up and the rest 4 %": shares of the phases in `whole` seconds of a run. Phases below half a
// percent are left out.
std::string phases_text(const PhaseTimes& times, double whole);

// "ranks: 2; a rank and step 13.2 kB in 1 message; waiting 4.1 %, ...": costs of several processes.
std::string ranks_text(const std::vector<RankTraffic>& ranks);

}  // namespace quoin
