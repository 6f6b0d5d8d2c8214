// Signals that stop a run.
#pragma once

#include <array>
#include <csignal>

#include "step/simulation.h"

namespace quoin {

// Stops the simulation at Ctrl-C, at the closing of the terminal or of the output pipe, and at SIGUSR1. The program
// mpirun forwards SIGUSR1, while it follows SIGTERM by SIGKILL within a second. The results are then written. A second
// signal ends the drawing of pictures alone. A third one, later than two seconds after the first, ends the program at
// once. That of a closed pipe does not count, as later output repeats it.
class StopOnSignal {
 public:
  explicit StopOnSignal(Simulation& simulation);  // must outlive this object
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace quoin
