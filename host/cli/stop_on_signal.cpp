#include "cli/stop_on_signal.h"

#include <atomic>

#include "files/gnuplot.h"

namespace quoin {

namespace {

std::atomic<Simulation*> running{nullptr};

extern "C" void stop_running(int) {
  stop_drawing = true;
  if (Simulation* simulation = running.load()) simulation->request_stop();
}

}  // namespace

StopOnSignal::StopOnSignal(Simulation& simulation) {
  running = &simulation;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    const bool of_terminal = kSignals[i] == SIGHUP || kSignals[i] == SIGPIPE;
    if (of_terminal && before_[i].sa_handler == SIG_IGN) continue;  // set by nohup
    struct sigaction action {};
    action.sa_handler = stop_running;
    action.sa_flags = SA_RESTART | (kSignals[i] == SIGPIPE ? 0 : static_cast<int>(SA_RESETHAND));
    sigaction(kSignals[i], &action, nullptr);
  }
}

StopOnSignal::~StopOnSignal() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  running = nullptr;
}

}  // namespace quoin
