// A few threads that run the same function side by side, many thousand times a second.
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <thread>
#include <vector>

namespace quoin {

// Threads wait by spinning for some microseconds (a phase of a step is not longer), then give way to others.
class ThreadPool {
 public:
  explicit ThreadPool(int thread_count)
      : thread_count_(thread_count),
        spins_(thread_count > static_cast<int>(std::thread::hardware_concurrency()) ? 0 : kSpins),
        next_(std::make_unique<Counter[]>(static_cast<std::size_t>(thread_count))) {
    for (int i = 1; i < thread_count; ++i) threads_.emplace_back([this, i] { work(i); });
  }
  ~ThreadPool() {
    job_ = nullptr;
    generation_.fetch_add(1, std::memory_order_release);
    for (std::thread& thread : threads_) thread.join();
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const { return thread_count_; }

  // Calls function(thread, piece) once for every piece 0 .. end.back() - 1, on any thread, in any order. Thread t
  // begins with the pieces [end[t - 1], end[t]), then takes what is left of the others': one that the machine holds up
  // delays nobody.
  template <class Function>
  void for_each(const std::vector<int>& end, Function& function) {
    const auto begin = [&](int t) { return t == 0 ? 0 : end[static_cast<std::size_t>(t - 1)]; };
    for (int t = 0; t < thread_count_; ++t)
      next_[static_cast<std::size_t>(t)].value.store(begin(t), std::memory_order_relaxed);
    auto share = [&](int thread) {
      for (int i = 0; i < thread_count_; ++i) {
        const auto owner = static_cast<std::size_t>((thread + i) % thread_count_);
        for (int piece; (piece = next_[owner].value.fetch_add(1, std::memory_order_relaxed)) < end[owner];)
          function(thread, piece);
      }
    };
    run(share);
  }

 private:
  struct alignas(64) Counter {
    std::atomic<int> value{0};
  };

  // Calls function(0) .. function(thread_count - 1), one on each thread, and returns when all are done. The function
  // must not throw.
  template <class Function>
  void run(Function& function) {
    if (thread_count_ == 1) {
      function(0);
      return;
    }
    job_ = [](void* f, int thread) { (*static_cast<Function*>(f))(thread); };
    argument_ = &function;
    busy_.store(thread_count_ - 1, std::memory_order_relaxed);
    generation_.fetch_add(1, std::memory_order_release);
    function(0);
    wait([this] { return busy_.load(std::memory_order_acquire) == 0; });
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
    for (unsigned seen = 0;;) {
      wait([&] { return generation_.load(std::memory_order_acquire) != seen; });
      ++seen;
      if (!job_) return;
      job_(argument_, thread);
      busy_.fetch_sub(1, std::memory_order_release);
    }
  }

  static constexpr int kSpins = 4000;  // about 20 to 50 us of waiting before the core is offered to others

  int thread_count_;
  int spins_;                        // 0 with more threads than cores: waiting would keep the others from working
  std::unique_ptr<Counter[]> next_;  // by thread: the next piece of its range
  void (*job_)(void*, int) = nullptr;
  void* argument_ = nullptr;
  alignas(64) std::atomic<unsigned> generation_{0};
  alignas(64) std::atomic<int> busy_{0};
  std::vector<std::thread> threads_;
};

}  // namespace quoin
