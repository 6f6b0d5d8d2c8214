#include "law/law_process.h"

#include <fmt/format.h>
#include <linux/futex.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "law/law_watch.h"

namespace quoin {

namespace {

constexpr std::size_t kPoints = 1024;  // largest piece of a batch; chunks of the host are smaller
constexpr long kSpins = 400;           // polls before a process sleeps, if there are processors for both

enum : std::uint32_t { kIdle, kAsked, kAnswered };

// Number of optional columns: stored energy, dissipation, 9 of the tangent, damage.
constexpr std::size_t kOptional = 1 + QUOIN_DISSIPATED_COUNT + 9 + QUOIN_DAMAGE_COUNT;

// A piece of a batch in shared memory; its columns of kPoints doubles follow.
struct alignas(64) Lane {
  std::atomic<std::uint32_t> turn;
  std::atomic<std::uint32_t> taken;  // by a thread of the host
  std::uint64_t count;
  std::uint8_t has_optional[kOptional], has_flags, has_status, has_state[256], has_property[256];
  quoin_status answer;
  std::uint64_t clamped, failed;
  std::uint32_t worst, any_yielding;
  double in_law;  // time in the law for this piece, s
};
static_assert(std::atomic<std::uint32_t>::is_always_lock_free);

void sleep_on(std::atomic<std::uint32_t>& word, std::uint32_t value, double seconds) {
  const timespec limit{static_cast<time_t>(seconds), static_cast<long>(1e9 * (seconds - std::floor(seconds)))};
  syscall(SYS_futex, &word, FUTEX_WAIT, value, &limit, nullptr, 0);
}
void wake(std::atomic<std::uint32_t>& word) { syscall(SYS_futex, &word, FUTEX_WAKE, 1, nullptr, nullptr, 0); }

void breathe() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

// Columns of a lane: jump, slip 2, traction 3, flags, status, optional ones, states, properties.
struct Columns {
  double* first;
  double* at(std::size_t k) const { return first + k * kPoints; }
  double* jump() const { return at(0); }
  double* slip(std::size_t k) const { return at(1 + k); }
  double* traction(std::size_t k) const { return at(3 + k); }
  std::uint32_t* flags() const { return reinterpret_cast<std::uint32_t*>(at(6)); }
  std::uint32_t* status() const { return reinterpret_cast<std::uint32_t*>(at(7)); }
  double* optional(std::size_t k) const { return at(8 + k); }
  double* state(std::size_t k) const { return at(8 + kOptional + k); }
  double* property(const quoin_law& law, std::size_t k) const { return state(law.state_count + k); }
};
std::size_t column_count(const quoin_law& law) { return 8 + kOptional + law.state_count + law.property_count; }
std::size_t lane_bytes(const quoin_law& law) { return sizeof(Lane) + column_count(law) * kPoints * sizeof(double); }

// Visits the optional columns of a batch in the order of Lane::has_optional.
template <class Batch, class Each>
void each_optional(Batch& batch, const Each& each) {
  std::size_t k = 0;
  each(k++, batch.energy_stored);
  for (auto& column : batch.dissipated) each(k++, column);
  for (auto& column : batch.tangent) each(k++, column);
  const bool has_damage = batch.struct_size >= offsetof(quoin_batch, damage) + sizeof batch.damage;
  for (auto& column : batch.damage) {
    if (has_damage) each(k, column);
    ++k;
  }
}

// Index of the law's property with this id; property_count: none.
std::size_t property_of(const quoin_law& law, const char* id) {
  std::size_t k = 0;
  while (k < law.property_count && id != law.properties[k]->id && std::strcmp(id, law.properties[k]->id) != 0) ++k;
  return k;
}

template <class From>
void gather(const From& column, std::size_t first, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = column.data[static_cast<std::int64_t>(first + i) * column.stride];
}
template <class To, class Value>
void scatter(const Value* from, std::size_t first, std::size_t count, const To& column) {
  for (std::size_t i = 0; i < count; ++i) column.data[static_cast<std::int64_t>(first + i) * column.stride] = from[i];
}

}  // namespace

// One process of the law, started by this process.
struct LawProcess::Impl {
  Impl(const quoin_law& law_in, const quoin_material* material_in, std::string path_in, int threads, double seconds)
      : law(law_in),
        material(material_in),
        path(std::move(path_in)),
        lanes(threads),
        limit(seconds),
        spins(2 * threads <= static_cast<int>(std::thread::hardware_concurrency())) {
    start();
  }
  ~Impl() {
    if (is_ours() && !ended) end(true);
    munmap(memory, bytes);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // Whether this process started the law's process; false in a fork.
  bool is_ours() const { return owner == getpid(); }
  void start();

  const quoin_law& law;
  const quoin_material* material;
  std::string path;
  int lanes;
  double limit;
  bool spins;  // whether processes poll instead of sleeping, as there are processors for all
  unsigned char* memory = nullptr;
  std::size_t bytes = 0;
  const pid_t owner = getpid();
  pid_t child = -1;
  mutable std::mutex mutex;  // guards the members below
  std::string fault;
  LawProcessTimes times;
  std::atomic<bool> ended{false};

  Lane& lane(int i) const { return *reinterpret_cast<Lane*>(memory + static_cast<std::size_t>(i) * lane_bytes(law)); }
  Columns columns(Lane& l) const { return {reinterpret_cast<double*>(&l + 1)}; }

  void wait_for(std::atomic<std::uint32_t>& word, std::uint32_t not_this) const {
    for (long i = 0; spins && i < kSpins; ++i) {
      if (word.load(std::memory_order_acquire) != not_this) return;
      breathe();
    }
  }

  // ---- In the law's process ----
  [[noreturn]] void serve() {
    end_of_watch();
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, SIG_DFL);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) std::signal(signal, SIG_IGN);  // the host handles these
    std::vector<std::thread> threads;
    for (int i = 0; i < lanes; ++i) threads.emplace_back([this, i] { serve_lane(lane(i)); });
    // PR_SET_PDEATHSIG would fire at the end of the thread that started this process, so it polls instead.
    while (getppid() == owner) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    _exit(0);
  }
  void serve_lane(Lane& l) {
    for (;;) {
      wait_for(l.turn, kIdle);
      while (l.turn.load(std::memory_order_acquire) != kAsked) sleep_on(l.turn, l.turn.load(), 1.0);
      answer(l);
      l.turn.store(kAnswered, std::memory_order_release);
      wake(l.turn);
      for (long i = 0; spins && i < kSpins && l.turn.load(std::memory_order_acquire) == kAnswered; ++i) breathe();
      while (l.turn.load(std::memory_order_acquire) == kAnswered) sleep_on(l.turn, kAnswered, 1.0);
    }
  }
  void answer(Lane& l) {
    const Columns c = columns(l);
    std::vector<quoin_in> old(law.state_count);
    std::vector<quoin_out> fresh(law.state_count);
    quoin_batch batch{};
    batch.struct_size = sizeof batch;
    batch.count = l.count;
    batch.normal_jump = {c.jump(), 1};
    for (std::size_t k = 0; k < 2; ++k) batch.slip_increment[k] = {c.slip(k), 1};
    for (std::size_t k = 0; k < 3; ++k)
      batch.traction_old[k] = {c.traction(k), 1}, batch.traction_new[k] = {c.traction(k), 1};
    for (std::size_t k = 0; k < law.state_count; ++k) {
      double* const column = l.has_state[k] ? c.state(k) : nullptr;
      old[k] = {column, 1}, fresh[k] = {column, 1};
    }
    batch.state_old = old.data(), batch.state_new = fresh.data();
    std::vector<quoin_property_column> properties;
    for (std::size_t k = 0; k < law.property_count; ++k) {
      if (l.has_property[k]) properties.push_back({law.properties[k]->id, {c.property(law, k), 1}});
    }
    batch.property_column_count = properties.size(), batch.property_columns = properties.data();
    each_optional(batch, [&](std::size_t k, quoin_out& column) {
      if (l.has_optional[k]) column = {c.optional(k), 1};
    });
    if (l.has_flags) batch.flags = {c.flags(), 1};
    if (l.has_status) batch.status = {c.status(), 1};
    const auto begin = Clock::now();
    l.answer = law.evaluate(material, &batch);
    l.in_law = seconds_since(begin);
    l.clamped = batch.clamped_count, l.failed = batch.failed_count;
    l.worst = batch.worst_status, l.any_yielding = batch.any_yielding;
  }

  // ---- In the host ----
  Lane* take_lane() {
    for (;;) {
      for (int i = 0; i < lanes; ++i) {
        if (lane(i).taken.exchange(1, std::memory_order_acquire) == 0) return &lane(i);
      }
      std::this_thread::yield();  // more threads than expected
    }
  }

  // Whether the process still runs; else records how it ended.
  bool alive(const Clock::time_point& asked) {
    const std::lock_guard guard(mutex);
    if (ended) return false;
    int status = 0;
    const pid_t gone = waitpid(child, &status, WNOHANG);
    if (gone == 0 && (limit <= 0.0 || seconds_since(asked) < limit)) return true;
    const std::string name = fmt::format("the law of {}, in its own process, ", path);
    if (gone == 0) {
      fault = name + fmt::format("did not return from a batch within {:g} s (--law-seconds)", limit);
    } else if (gone < 0 || WIFEXITED(status)) {
      fault = name + fmt::format("called exit({})", gone < 0 ? -1 : WEXITSTATUS(status));
    } else {
      const int signal = WTERMSIG(status);
      const char* const words = signal == SIGABRT ? "aborted, or threw what a law must not throw" : "crashed";
      const char* const abbreviation = sigabbrev_np(signal);
      fault = name + fmt::format("{} (SIG{})", words, abbreviation ? abbreviation : std::to_string(signal).c_str());
    }
    fault += "; tell its author or choose another law";
    end(gone == 0);
    return false;
  }
  void end(bool reap) {
    ended = true;
    if (!reap || child <= 0) return;
    kill(child, SIGKILL);
    while (waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
  }

  quoin_status ask(Lane& l, const quoin_batch& batch, std::size_t first, std::size_t count) {
    const Columns c = columns(l);
    l.count = count;
    gather(batch.normal_jump, first, count, c.jump());
    for (std::size_t k = 0; k < 2; ++k) gather(batch.slip_increment[k], first, count, c.slip(k));
    for (std::size_t k = 0; k < 3; ++k) gather(batch.traction_old[k], first, count, c.traction(k));
    for (std::size_t k = 0; k < law.state_count; ++k) {
      l.has_state[k] = batch.state_old[k].data != nullptr;
      if (l.has_state[k]) gather(batch.state_old[k], first, count, c.state(k));
    }
    std::fill_n(l.has_property, law.property_count, std::uint8_t{0});
    for (std::size_t k = 0; k < batch.property_column_count; ++k) {
      const quoin_property_column& column = batch.property_columns[k];
      const std::size_t p = column.id && column.values.data ? property_of(law, column.id) : law.property_count;
      if (p == law.property_count) return QUOIN_ERROR_ARGUMENT;  // as the law does for an unknown property
      l.has_property[p] = 1;
      gather(column.values, first, count, c.property(law, p));
    }
    std::fill_n(l.has_optional, kOptional, std::uint8_t{0});
    each_optional(batch, [&](std::size_t k, const quoin_out& column) { l.has_optional[k] = column.data != nullptr; });
    l.has_flags = batch.flags.data != nullptr;
    l.has_status = batch.status.data != nullptr;

    const auto asked = Clock::now();
    l.turn.store(kAsked, std::memory_order_release);
    wake(l.turn);
    wait_for(l.turn, kAsked);
    while (l.turn.load(std::memory_order_acquire) != kAnswered) {
      sleep_on(l.turn, kAsked, 0.05);
      if (l.turn.load(std::memory_order_acquire) != kAnswered && !alive(asked)) return QUOIN_ERROR_INTERNAL;
    }
    const quoin_status status = l.answer;
    if (status == QUOIN_OK) {
      for (std::size_t k = 0; k < 3; ++k) scatter(c.traction(k), first, count, batch.traction_new[k]);
      for (std::size_t k = 0; k < law.state_count; ++k) {
        if (l.has_state[k] && batch.state_new[k].data) scatter(c.state(k), first, count, batch.state_new[k]);
      }
      each_optional(batch, [&](std::size_t k, const quoin_out& column) {
        if (l.has_optional[k]) scatter(c.optional(k), first, count, column);
      });
      if (l.has_flags) scatter(c.flags(), first, count, batch.flags);
      if (l.has_status) scatter(c.status(), first, count, batch.status);
    }
    const std::lock_guard guard(mutex);
    times.seconds += seconds_since(asked);
    times.in_law += l.in_law;
    ++times.batches;
    return status;
  }
};

void LawProcess::Impl::start() {
  bytes = static_cast<std::size_t>(lanes) * lane_bytes(law);
  void* const shared = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  const auto refuse = [&] {
    throw Error(Exit::numerical, fmt::format("law '{}': no process of its own could be started: {}; run without "
                                             "--isolate-law",
                                             law.id, std::error_code(errno, std::generic_category()).message()));
  };
  if (shared == MAP_FAILED) refuse();
  memory = static_cast<unsigned char*>(shared);
  for (int i = 0; i < lanes; ++i) new (&lane(i)) Lane{};
  std::fflush(nullptr);  // else both processes would write the content of buffers
  child = fork();
  if (child == 0) serve();
  if (child < 0) {
    const int why = errno;
    munmap(shared, bytes);
    errno = why;
    refuse();
  }
}

LawProcess::LawProcess(const quoin_law& law, const quoin_material* material, std::string path, int threads,
                       double seconds) {
  for (const auto& [what, count] : {std::pair{"states", law.state_count}, {"properties", law.property_count}}) {
    if (count > sizeof(Lane::has_state))
      throw Error(Exit::law_refused, fmt::format("law '{}' has {} {}; a process of its own takes {} at most", law.id,
                                                 count, what, sizeof(Lane::has_state)));
  }
  started_.push_back(std::make_unique<Impl>(law, material, std::move(path), std::max(1, threads), seconds));
  current_ = started_.back().get();
}

LawProcess::~LawProcess() = default;

// A law's process belongs to the process that started it; a fork starts its own.
LawProcess::Impl& LawProcess::ours() {
  if (Impl& s = *current_; s.is_ours() || s.ended) return s;
  const std::lock_guard guard(starting_);
  if (Impl& s = *current_; !s.is_ours()) {
    started_.push_back(std::make_unique<Impl>(s.law, s.material, s.path, s.lanes, s.limit));
    current_ = started_.back().get();
  }
  return *current_;
}

quoin_status LawProcess::evaluate(quoin_batch* batch) {
  Impl& s = ours();
  if (s.ended) return QUOIN_ERROR_INTERNAL;
  batch->clamped_count = batch->failed_count = 0;
  batch->worst_status = batch->any_yielding = 0;
  Lane* const lane = s.take_lane();
  quoin_status status = QUOIN_OK;
  for (std::size_t first = 0; first < batch->count && status == QUOIN_OK; first += kPoints) {
    status = s.ask(*lane, *batch, first, std::min<std::size_t>(kPoints, batch->count - first));
    batch->clamped_count += lane->clamped, batch->failed_count += lane->failed;
    batch->worst_status = std::max(batch->worst_status, lane->worst);
    batch->any_yielding |= lane->any_yielding;
  }
  lane->taken.store(0, std::memory_order_release);
  return status;
}

std::string LawProcess::fault() const {
  const Impl& s = *current_;
  if (!s.is_ours()) return "";
  const std::lock_guard guard(s.mutex);
  return s.fault;
}

LawProcessTimes LawProcess::times() const {
  const Impl& s = *current_;
  if (!s.is_ours()) return {};
  const std::lock_guard guard(s.mutex);
  return s.times;
}

}  // namespace quoin
