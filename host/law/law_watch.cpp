#include "law/law_watch.h"

#include <execinfo.h>
#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>

#include "base/error.h"

namespace quoin {

namespace {

// Data for signal handlers, which must not allocate or lock.
struct Known {
  std::atomic<std::uintptr_t> begin{0}, end{0};  // range of the law's code; end 0: unused
  std::array<char, 512> path{};
};
std::array<Known, 64> known;
std::mutex writing;
std::array<char, 512> loading{};  // path of the library being loaded; empty: none
std::atomic<bool> watching{false};

void keep_name(std::array<char, 512>& to, const std::string& path) {
  const std::size_t size = std::min(path.size(), to.size() - 1);
  std::memcpy(to.data(), path.data(), size);
  to[size] = '\0';
}

struct Range {
  std::uintptr_t inside, begin, end;
};

int find_range(dl_phdr_info* info, std::size_t, void* to) {
  Range& range = *static_cast<Range*>(to);
  std::uintptr_t begin = UINTPTR_MAX, end = 0;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& part = info->dlpi_phdr[i];
    if (part.p_type != PT_LOAD) continue;
    begin = std::min<std::uintptr_t>(begin, info->dlpi_addr + part.p_vaddr);
    end = std::max<std::uintptr_t>(end, info->dlpi_addr + part.p_vaddr + part.p_memsz);
  }
  if (range.inside < begin || range.inside >= end) return 0;
  range.begin = begin, range.end = end;
  return 1;
}

// Path of the innermost law on the stack; null: none.
const char* law_on_stack() {
  std::array<void*, 256> frames{};
  const int count = backtrace(frames.data(), static_cast<int>(frames.size()));
  for (int i = 0; i < count; ++i) {
    const auto address = reinterpret_cast<std::uintptr_t>(frames[static_cast<std::size_t>(i)]);
    for (const Known& law : known) {
      if (address >= law.begin.load() && address < law.end.load()) return law.path.data();
    }
  }
  return nullptr;
}

void say(std::initializer_list<const char*> words) {
  for (const char* word : words) {
    if (write(STDERR_FILENO, word, std::strlen(word)) < 0) return;
  }
}

// Prints which law is to blame and ends the program; returns if it was none.
void name_faulty_law(const char* deed) {
  if (loading[0] != '\0') {
    say({"quoin: law library ", loading.data(), " ", deed, " while it was loaded; tell its author\n"});
    _exit(static_cast<int>(Exit::law_refused));
  }
  if (const char* law = law_on_stack()) {
    say({"quoin: the law of ", law, " ", deed,
         " in the middle of the work, which ends here without results; tell its author or choose another law\n"});
    _exit(static_cast<int>(Exit::numerical));
  }
}

extern "C" void on_crash(int signal) {
  const char* name = signal == SIGSEGV  ? "crashed (SIGSEGV)"
                     : signal == SIGBUS ? "crashed (SIGBUS)"
                     : signal == SIGFPE ? "crashed (SIGFPE)"
                     : signal == SIGILL ? "crashed (SIGILL)"
                                        : "aborted, or threw what a law must not throw";
  name_faulty_law(name);
  // An exception in a function of the C++ library that must not throw, such as a directory iterator: memory ran out.
  if (signal == SIGABRT && std::uncaught_exceptions() > 0) {
    say({"quoin: out of memory; make the scene smaller\n"});
    _exit(static_cast<int>(Exit::numerical));
  }
  std::signal(signal, SIG_DFL);  // our own error: as without a watch
  raise(signal);
}

extern "C" void on_exit_called() {
  if (!watching.load()) return;
  name_faulty_law("called exit()");
  say({"quoin: internal error: exit() was called in the middle of the work; please report it\n"});
  _exit(static_cast<int>(Exit::numerical));
}

}  // namespace

void watch_laws() {
  std::array<void*, 1> loads_the_unwinder{};
  backtrace(loads_the_unwinder.data(), 1);
  alignas(16) static std::array<char, 65536> stack;  // stack for handlers, as the law may have exhausted its own
  const stack_t own{stack.data(), 0, stack.size()};
  sigaltstack(&own, nullptr);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    struct sigaction before {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_DFL) continue;
    struct sigaction action {};
    action.sa_handler = on_crash;
    action.sa_flags = SA_ONSTACK | SA_NODEFER;
    sigaction(signal, &action, nullptr);
  }
  watching = true;
  std::atexit(on_exit_called);
  std::at_quick_exit(on_exit_called);
}

void end_of_watch() noexcept { watching = false; }

WatchedLoading::WatchedLoading(const std::string& path) { keep_name(loading, path); }
WatchedLoading::~WatchedLoading() { loading[0] = '\0'; }

void note_law(const void* inside, const std::string& path) {
  Range range{reinterpret_cast<std::uintptr_t>(inside), 0, 0};
  if (dl_iterate_phdr(find_range, &range) == 0) return;
  const std::lock_guard guard(writing);
  const auto free = std::find_if(known.begin(), known.end(), [](const Known& law) { return law.end == 0; });
  if (free == known.end()) return;
  keep_name(free->path, path);
  free->begin = range.begin;
  free->end = range.end;
}

void unregister_law(const void* inside) {
  const auto address = reinterpret_cast<std::uintptr_t>(inside);
  const std::lock_guard guard(writing);
  for (Known& law : known) {
    if (address < law.begin || address >= law.end) continue;
    law.end = 0;
    return;
  }
}

}  // namespace quoin
