// Signals that stop a run.
#pragma once

#include <array>
#include <csignal>

#include "step/simulation.h"

namespace quoin {

// Ctrl-C asks the simulation to stop. A terminal that closes, a closed pipe of our output, and SIGUSR1 do so, too.
// SIGUSR1 is handed on by mpirun, which follows SIGTERM by SIGKILL within a second. A second time ends the program at
// once; but a reader that is gone will be written to again.
class StopOnSignal {
 public:
  explicit StopOnSignal(Simulation& simulation);  // which must outlive this
  ~StopOnSignal();
  StopOnSignal(const StopOnSignal&) = delete;
  StopOnSignal& operator=(const StopOnSignal&) = delete;

 private:
  static constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGPIPE};
  std::array<struct sigaction, kSignals.size()> before_{};
};

}  // namespace quoin
