#include "cli/stop_on_signal.h"

#include <atomic>
#include <cstdint>
#include <ctime>

#include "files/gnuplot.h"

namespace quoin {

namespace {

// A terminal, a shell and mpirun may each send the signal of one Ctrl-C. Within this time, ms, signals end no program.
constexpr std::int64_t kOneStop = 2000;

std::atomic<Simulation*> running{nullptr};
std::atomic<int> count{0};
std::atomic<std::int64_t> first{0};  // time of the first signal, ms

extern "C" void stop_running(int signal) {
  stop_drawing = true;
  if (Simulation* simulation = running.load()) simulation->request_stop();
  if (signal == SIGPIPE) return;  // later output repeats it
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t time = std::int64_t{1000} * now.tv_sec + now.tv_nsec / 1000000;
  if (++count == 1) first = time;
  if (count < 3 || time - first <= kOneStop) return;
  std::signal(signal, SIG_DFL);
  std::raise(signal);  // ends the program when this function returns
}

}  // namespace

StopOnSignal::StopOnSignal(Simulation& simulation) {
  running = &simulation;
  count = 0;
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &before_[i]);
    const bool of_terminal = kSignals[i] == SIGHUP || kSignals[i] == SIGPIPE;
    if (of_terminal && before_[i].sa_handler == SIG_IGN) continue;  // set by nohup
    struct sigaction action {};
    action.sa_handler = stop_running;
    action.sa_flags = SA_RESTART;
    sigaction(kSignals[i], &action, nullptr);
  }
}

StopOnSignal::~StopOnSignal() {
  running = nullptr;
  if (count > 0) return;  // the program ends now: a repeated signal must not change its exit code
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
}

}  // namespace quoin
