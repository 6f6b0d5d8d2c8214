#include "law/law_trial.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>

#include "base/error.h"
#include "law/law_watch.h"

namespace quoin {

namespace {

constexpr char kCameBack = '+', kThrew = '!';

[[noreturn]] void load_and_report(const std::function<void()>& load, int to) {
  end_of_watch();  // the exit status reports the result
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, SIG_DFL);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  const int null = open("/dev/null", O_RDWR);
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(null, number);
  char how = kCameBack;
  try {
    load();
  } catch (const Error&) {
  } catch (const std::bad_alloc&) {  // memory may run out in our code too
  } catch (...) {
    how = kThrew;
  }
  while (write(to, &how, 1) < 0 && errno == EINTR) {
  }
  _exit(how);
}

// Byte that the process wrote before it ended or closed its end; 0: none; -1: time limit.
int read_answer(int from, double seconds) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  for (;;) {
    const double left = seconds - std::chrono::duration<double>(Clock::now() - begin).count();
    if (seconds > 0.0 && left <= 0.0) return -1;
    pollfd poll_set{from, POLLIN, 0};
    const int ready = poll(&poll_set, 1, seconds > 0.0 ? static_cast<int>(1e3 * left) + 1 : -1);
    if (ready <= 0) continue;  // interrupted, or not ready
    char how = 0;
    const ssize_t count = read(from, &how, 1);
    if (count < 0 && errno == EINTR) continue;
    return count == 1 ? how : 0;
  }
}

}  // namespace

std::string fault_of_loading(const std::function<void()>& load, double seconds) {
  std::fflush(nullptr);  // else both processes would write the content of buffers
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return "";
  const pid_t child = fork();
  if (child == 0) load_and_report(load, ends[1]);
  close(ends[1]);
  const int how = child > 0 ? read_answer(ends[0], seconds) : kCameBack;
  close(ends[0]);
  if (child < 0) return "";
  if (how != 0) kill(child, SIGKILL);  // it returned, but its own threads may keep it alive
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  const int code = how <= 0 && WIFEXITED(status) ? WEXITSTATUS(status) : how;
  if (code == kCameBack) return "";
  if (code == kThrew) return "threw what a law must not throw";
  if (how < 0) return fmt::format("did not come back within {:g} s", seconds);
  if (!WIFSIGNALED(status))
    return fmt::format("called exit({}) or _exit({})", WEXITSTATUS(status), WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  for (const int from_outside : {SIGKILL, SIGTERM, SIGINT, SIGHUP, SIGQUIT}) {
    if (signal == from_outside) return "";  // not the law's fault
  }
  const char* const abbreviation = sigabbrev_np(signal);
  return fmt::format("{} (SIG{})", signal == SIGABRT ? "aborted, or threw what a law must not throw" : "crashed",
                     abbreviation ? abbreviation : std::to_string(signal).c_str());
}

}  // namespace quoin
