// Threads that run the same function in parallel, many thousand times a second.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <system_error>
#include <thread>
#include <vector>

namespace quoin {

// Threads wait by spinning for some microseconds (a phase of a step is not longer), then yield the core.
//
// No call waits for an idle thread: it ends when all of its pieces are done. A delayed thread finds no piece when it
// resumes. So a core that other programs occupy costs only its share of the work.
class ThreadPool {
 public:
  explicit ThreadPool(int thread_count)
      : thread_count_(thread_count),
        spins_(thread_count > static_cast<int>(std::thread::hardware_concurrency()) ? 0 : kSpins),
        ranges_(std::make_unique<Range[]>(static_cast<std::size_t>(thread_count))) {
    try {
      for (int i = 1; i < thread_count; ++i) threads_.emplace_back([this, i] { work(i); });
    } catch (const std::system_error&) {  // the system has no more threads
      thread_count_ = 1 + static_cast<int>(threads_.size());
    }
  }
  ~ThreadPool() {
    stop_.store(true, std::memory_order_relaxed);
    call_.fetch_add(1, std::memory_order_release);
    for (std::thread& thread : threads_) thread.join();
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const { return thread_count_; }  // fewer than requested if the system has no more

  // Calls function(thread, piece) once for every piece 0 .. end.back() - 1, on any thread, in any order. Thread t
  // begins with the pieces [end[t - 1], end[t]), then takes remaining pieces of other threads. The function must not
  // throw.
  template <class Function>
  void for_each(const std::vector<int>& end, Function& function) {
    if (thread_count_ == 1) {
      for (int piece = 0; piece < end.back(); ++piece) function(0, piece);
      return;
    }
    const std::uint32_t call = call_.load(std::memory_order_relaxed) + 1;
    // All pieces of the last call are done. A thread that still searches for one must not see its counters with the new
    // function.
    for (int t = 0; t < thread_count_; ++t) range(t).next.store(ticket(call, kNoPiece), std::memory_order_release);
    run_.store([](void* f, int thread, int piece) { (*static_cast<Function*>(f))(thread, piece); },
               std::memory_order_release);
    argument_.store(&function, std::memory_order_release);
    done_.store(0, std::memory_order_relaxed);
    for (int t = 0; t < thread_count_; ++t) {
      range(t).end.store(end[static_cast<std::size_t>(t)], std::memory_order_release);
      const int begin = t == 0 ? 0 : end[static_cast<std::size_t>(t - 1)];
      range(t).next.store(ticket(call, begin), std::memory_order_release);
    }
    call_.store(call, std::memory_order_release);
    take_pieces(0, call);
    wait([&] { return done_.load(std::memory_order_acquire) == end.back(); });
  }

 private:
  // Pieces of a thread. next: the call and its next piece in one word. So a thread of an earlier call cannot take a
  // piece of a later one.
  struct alignas(64) Range {
    std::atomic<std::uint64_t> next{0};
    std::atomic<int> end{0};
  };
  Range& range(int thread) { return ranges_[static_cast<std::size_t>(thread)]; }
  static std::uint64_t ticket(std::uint32_t call, int piece) {
    return std::uint64_t{call} << 32 | static_cast<std::uint32_t>(piece);
  }

  void take_pieces(int thread, std::uint32_t call) {
    // Function of this call, or of a later call, which has no piece for this ticket.
    const auto run = run_.load(std::memory_order_acquire);
    void* const argument = argument_.load(std::memory_order_acquire);
    for (int i = 0; i < thread_count_; ++i) {
      auto& [next, end] = range((thread + i) % thread_count_);
      for (std::uint64_t taken = next.load(std::memory_order_acquire); taken >> 32 == call;) {
        const int piece = static_cast<int>(taken & 0xffffffffu);
        if (piece >= end.load(std::memory_order_acquire)) break;
        if (!next.compare_exchange_weak(taken, taken + 1, std::memory_order_acq_rel, std::memory_order_acquire))
          continue;
        run(argument, thread, piece);
        done_.fetch_add(1, std::memory_order_release);
        taken = next.load(std::memory_order_acquire);
      }
    }
  }

  template <class Condition>
  void wait(Condition ready) const {
    for (int spins = 0; !ready(); ++spins) {
      if (spins < spins_) {
#if defined(__x86_64__) || defined(__i386__)
        __builtin_ia32_pause();
#endif
      } else {
        std::this_thread::yield();
      }
    }
  }

  void work(int thread) {
    for (std::uint32_t seen = 0;;) {
      wait([&] { return call_.load(std::memory_order_acquire) != seen; });
      seen = call_.load(std::memory_order_acquire);
      if (stop_.load(std::memory_order_relaxed)) return;
      take_pieces(thread, seen);
    }
  }

  static constexpr int kNoPiece = 0x7fffffff;
  static constexpr int kSpins = 4000;  // about 20 to 50 us of waiting before the core is yielded

  int thread_count_;
  int spins_;                        // 0 with more threads than cores, where spinning would slow the working threads
  std::unique_ptr<Range[]> ranges_;  // by thread
  std::atomic<void (*)(void*, int, int)> run_{nullptr};
  std::atomic<void*> argument_{nullptr};
  std::atomic<bool> stop_{false};
  alignas(64) std::atomic<std::uint32_t> call_{0};
  alignas(64) std::atomic<int> done_{0};
  std::vector<std::thread> threads_;
};

// Divides pieces of these weights into one range per thread, of about equal weight; returns the end of each range.
inline std::vector<int> shares(const std::vector<double>& weight, int thread_count) {
  double total = 0.0, so_far = 0.0;
  for (const double w : weight) total += w;
  std::vector<int> end;
  std::size_t i = 0;
  for (int t = 0; t < thread_count; ++t) {
    const double share = total * (t + 1) / thread_count;
    while (i < weight.size() && (t + 1 == thread_count || so_far + 0.5 * weight[i] <= share)) so_far += weight[i++];
    end.push_back(static_cast<int>(i));
  }
  return end;
}

// Calls visit(begin, end) for each part of [0, count), on the threads of the pool; null: on the caller alone. Parts
// have `size` items whatever the number of threads. Throws what the first of them has thrown.
template <class Visit>
void each_part(ThreadPool* pool, std::size_t count, std::size_t size, const Visit& visit) {
  const std::size_t parts = (count + size - 1) / size;
  const auto visit_part = [&](std::size_t part) { visit(part * size, std::min(count, (part + 1) * size)); };
  if (!pool || pool->thread_count() == 1 || parts < 2) {
    for (std::size_t part = 0; part < parts; ++part) visit_part(part);
    return;
  }
  std::vector<std::exception_ptr> thrown(parts);
  auto run = [&](int, int part) {
    try {
      visit_part(static_cast<std::size_t>(part));
    } catch (...) {
      thrown[static_cast<std::size_t>(part)] = std::current_exception();
    }
  };
  pool->for_each(shares(std::vector<double>(parts, 1.0), pool->thread_count()), run);
  for (const std::exception_ptr& exception : thrown) {
    if (exception) std::rethrow_exception(exception);
  }
}

}  // namespace quoin
