#include "ensemble/pool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <deque>
#include <fstream>
#include <map>

#include "base/any_error.h"
#include "base/duration_text.h"
#include "base/error.h"
#include "files/file.h"
#include "files/notice.h"
#include "law/law_calls.h"

namespace quoin::ensemble {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr int kClaimedByOthers = 120;  // exit code of a process whose sample another one has claimed
constexpr int kKilledTooOften = 3;     // number of kills after which a sample counts as failed
constexpr long kPoll = 50;             // ms between two checks for samples of other processes

std::atomic<bool> stop_asked{false};
extern "C" void stop_the_pool(int) { stop_asked = true; }

// Records signals while samples are computed.
class StopHandler {
 public:
  StopHandler() {
    struct sigaction action {};
    action.sa_handler = stop_the_pool;
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before_[i]);
  }
  ~StopHandler() { restore(); }
  StopHandler(const StopHandler&) = delete;
  StopHandler& operator=(const StopHandler&) = delete;
  void restore() const {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  }

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, 3> before_{};
};

// A sample in a process of its own, and the pipe for that process's error message.
struct UnderWay {
  std::uint64_t sample;
  int reasons;  // end to read from
};

// Message in the pipe, which is closed.
std::string reason_in(int pipe) {
  std::array<char, 4096> text{};
  const ssize_t count = read(pipe, text.data(), text.size());
  close(pipe);
  return {text.data(), static_cast<std::size_t>(std::max<ssize_t>(0, count))};
}

std::string last_line(const fs::path& file) {
  std::ifstream stream(file);
  std::string line, last;
  while (std::getline(stream, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

bool is_crash(int signal) {
  for (const int of_crash : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGSYS}) {
    if (signal == of_crash) return true;
  }
  return false;
}

class Pool {
 public:
  Pool(const StudyFolder& folder, const PoolSettings& settings, const SampleActions& actions)
      : folder_(folder), settings_(settings), actions_(actions), parent_(getpid()) {}

  void run() {
    for (std::uint64_t i = settings_.first; i <= settings_.samples; ++i) {
      if (!actions_.is_finished(folder_.sample(i))) left_.push_back(i);
    }
    total_ = settings_.samples + 1 - settings_.first;
    done_ = done_before_ = total_ - left_.size();
    if (!left_.empty())
      notice(fmt::format("{} samples{}, {} of these done before; {} side by side", settings_.samples,
                         settings_.first == 0 ? " and one of the means" : "", done_before_, settings_.jobs));
    while (true) {
      start_some();
      const bool no_more = left_.empty() || stop_asked || !fault_.empty() || !settings_.wait_for_others;
      if (running_.empty() && no_more) break;
      wait_for_one();
    }
    if (!fault_.empty()) throw Error(Exit::bad_input, fault_);
    if (stop_asked)
      throw Error(Exit::interrupted, "interrupted; finished samples are kept, the same command computes the others");
  }

 private:
  void start_some() {
    const auto now = Clock::now();
    for (std::size_t tries = left_.size(); tries > 0 && !stop_asked && fault_.empty(); --tries) {
      if (running_.size() >= static_cast<std::size_t>(settings_.jobs)) return;
      const std::uint64_t sample = left_.front();
      if (const auto held = held_until_.find(sample); held != held_until_.end() && now < held->second) {
        left_.pop_front();
        left_.push_back(sample);
        continue;
      }
      left_.pop_front();
      if (actions_.is_finished(folder_.sample(sample))) {  // computed by another process
        ++done_;
        print_progress();
        continue;
      }
      if (!start(sample)) {
        left_.push_front(sample);
        if (running_.empty()) throw Error(Exit::numerical, "no process can be started; close other programs");
        return;
      }
    }
  }

  bool start(std::uint64_t sample) {
    std::fflush(nullptr);
    std::array<int, 2> ends{};
    if (pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK) != 0) return false;
    const pid_t child = fork();
    if (child == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent_) _exit(127);  // the parent died before prctl
      handler_.restore();
      _exit(compute(sample, ends[1]));
    }
    close(ends[1]);
    if (child < 0)
      close(ends[0]);
    else
      running_[child] = {sample, ends[0]};
    return child > 0;
  }

  // Computes a sample in its own process. Returns the exit code.
  int compute(std::uint64_t sample, int reasons) {
    const fs::path place = folder_.sample(sample);
    const LawWatchdog watchdog(kLawSeconds, end_program(kLawSeconds));
    int code = 0;
    try {
      const std::unique_ptr<Claim> claim = Claim::take(folder_.claim(sample));
      if (!claim || actions_.is_finished(place)) return kClaimedByOthers;
      claim->sign();
      make_folder(place);
      // Output of the sample goes to its folder, and thus that of a law before a crash.
      const int log = open((place / "log.txt").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      if (log >= 0) dup2(log, STDOUT_FILENO), dup2(log, STDERR_FILENO);
      actions_.compute(sample, place);
    } catch (const std::exception& thrown) {
      const Error error = any_error(thrown);
      notice(fmt::format("quoin: {}", error.what()));
      code = static_cast<int>(error.exit_code);
      // Also by a pipe, as the disk of the log may be full. If the pipe fails too, only the message is missing.
      [[maybe_unused]] const ssize_t count = write(reasons, error.what(), std::strlen(error.what()));
    }
    std::fflush(nullptr);
    return code;
  }

  void wait_for_one() {
    int status = 0;
    const pid_t child = waitpid(-1, &status, WNOHANG);
    if (child <= 0) {
      if (stop_asked && !reported_) {
        for (const auto& [process, under_way] : running_) kill(process, SIGKILL);
        reported_ = true;
      }
      // Signals end the sleep.
      const timespec nap{0, kPoll * 1000000 / (running_.empty() ? 1 : 10)};
      nanosleep(&nap, nullptr);
      return;
    }
    const auto found = running_.find(child);
    if (found == running_.end()) return;
    const std::uint64_t sample = found->second.sample;
    const std::string said = reason_in(found->second.reasons);
    running_.erase(found);
    if (stop_asked) return;
    if (actions_.is_finished(folder_.sample(sample))) {
      ++done_;
      print_progress();
      return;
    }
    judge(sample, status, said);
  }

  // Handles a process that has ended without finishing its sample.
  void judge(std::uint64_t sample, int status, const std::string& said) {
    const fs::path place = folder_.sample(sample);
    if (WIFEXITED(status) && WEXITSTATUS(status) == kClaimedByOthers) {
      if (!settings_.wait_for_others) return;
      left_.push_back(sample);
      held_until_[sample] = Clock::now() + std::chrono::milliseconds(kPoll);
      return;
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == static_cast<int>(Exit::bad_input)) {
      if (!fault_.empty()) return;
      fault_ = fmt::format("sample {} could not be computed: {}", sample, said);
      if (!running_.empty())
        notice(fmt::format("quoin: {}; no other one begins, those under way ({}) come to their end", fault_,
                           running_.size()));
      return;
    }
    const bool killed = WIFSIGNALED(status) && !is_crash(WTERMSIG(status));
    if (killed && ++killed_[sample] < kKilledTooOften) {
      notice(fmt::format("sample {} was killed (signal {}); once more", sample, WTERMSIG(status)));
      left_.push_back(sample);
      return;
    }
    const std::unique_ptr<Claim> claim = Claim::take(folder_.claim(sample));
    if (!claim || actions_.is_finished(place)) return left_.push_back(sample);
    const std::string end = WIFSIGNALED(status) ? fmt::format("its process ended by signal {} ({})", WTERMSIG(status),
                                                              strsignal(WTERMSIG(status)))
                                                : fmt::format("its process ended with code {}", WEXITSTATUS(status));
    std::string reason = said.empty() || killed ? end : said;
    const std::string last = said.empty() && !killed ? last_line(place / "log.txt") : "";
    if (!last.empty()) reason += "; its log ends with: " + last;
    actions_.fail(sample, place, reason);
    ++done_;
    print_progress();
  }

  // Prints progress every few seconds; on a terminal it replaces the line.
  void print_progress() {
    const auto now = Clock::now();
    const bool last = done_ == total_;
    const double apart = terminal_ ? 0.5 : 10.0;
    if (!last && now < reported_at_ + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(apart)))
      return;
    reported_at_ = now;
    const double spent = std::chrono::duration<double>(now - start_).count();
    const double each = spent / static_cast<double>(std::max<std::uint64_t>(1, done_ - done_before_));
    const std::string text =
        fmt::format("{}/{} samples, {}{}", done_, total_, duration_text(spent),
                    last ? "" : ", about " + duration_text(each * static_cast<double>(total_ - done_)) + " left");
    if (!terminal_) return notice(text);
    std::fprintf(stderr, "\r%-60s%s", text.c_str(), last ? "\n" : "");
    std::fflush(stderr);
  }

  const StudyFolder& folder_;
  const PoolSettings& settings_;
  const SampleActions& actions_;
  const pid_t parent_;
  const StopHandler handler_;
  std::deque<std::uint64_t> left_;
  std::map<std::uint64_t, Clock::time_point> held_until_;  // of samples of other processes
  std::map<std::uint64_t, int> killed_;
  std::map<pid_t, UnderWay> running_;
  std::uint64_t total_ = 0, done_before_ = 0;
  std::uint64_t done_ = 0;  // by this process, and by others as far as it has seen
  std::string fault_;
  bool reported_ = false;
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point reported_at_ = start_;
};

}  // namespace

void compute_samples(const StudyFolder& folder, const PoolSettings& settings, const SampleActions& actions) {
  stop_asked = false;
  Pool(folder, settings, actions).run();
}

}  // namespace quoin::ensemble
