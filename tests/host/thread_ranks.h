// Ranks as threads of one process: what each does is what processes do that MPI joins, and tests need no MPI.
#pragma once

#include <algorithm>
#include <barrier>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/ranks.h"

namespace quoin {

// What the threads tell each other by.
struct RanksTogether {
  explicit RanksTogether(int count_in) : count(count_in), barrier(count_in), places(static_cast<std::size_t>(count)) {}
  int count;
  std::barrier<> barrier;
  std::vector<void*> places;  // by rank: of what it gives in the call that all are in
  std::mutex mutex;
  std::condition_variable sent;
  std::map<std::pair<int, int>, std::deque<std::vector<double>>> on_their_way;  // by sender and receiver
};

class ThreadRanks : public Ranks {
 public:
  ThreadRanks(RanksTogether& all, int rank) : all_(all), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return all_.count; }
  int count_on_this_machine() const override { return all_.count; }

  void start(std::span<const Parcel> send, std::span<const Parcel> receive) override {
    const std::lock_guard lock(all_.mutex);
    for (const Parcel& p : send) all_.on_their_way[{rank_, p.rank}].emplace_back(p.values.begin(), p.values.end());
    all_.sent.notify_all();
    expected_.assign(receive.begin(), receive.end());
  }
  void finish() override {
    std::unique_lock lock(all_.mutex);
    for (const Parcel& p : expected_) {
      auto& queue = all_.on_their_way[{p.rank, rank_}];
      all_.sent.wait(lock, [&] { return !queue.empty(); });
      std::copy(queue.front().begin(), queue.front().end(), p.values.begin());
      queue.pop_front();
    }
    expected_.clear();
  }
  void largest(std::span<double> values) override {
    std::vector<double> own(values.begin(), values.end());
    with_all(&own, [&](int, void* of_rank) {
      const auto& theirs = *static_cast<std::vector<double>*>(of_rank);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::max(values[i], theirs[i]);
    });
  }
  void gather(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
    std::byte* to = all.data();
    with_all(const_cast<std::byte*>(own.data()), [&](int r, void* theirs) {
      const std::size_t size = sizes[static_cast<std::size_t>(r)];
      if (size > 0) std::memcpy(to, theirs, size);
      to += size;
    });
  }
  void share(std::span<std::byte> bytes) override {
    with_all(bytes.data(), [&](int r, void* theirs) {
      if (r == 0 && rank_ != 0) std::memcpy(bytes.data(), theirs, bytes.size());
    });
  }
  bool all_here(double) override { return true; }
  void abort(int) override { std::terminate(); }

 private:
  void with_all(void* own, const std::function<void(int rank, void* theirs)>& visit) {
    all_.places[static_cast<std::size_t>(rank_)] = own;
    all_.barrier.arrive_and_wait();
    for (int r = 0; r < all_.count; ++r) visit(r, all_.places[static_cast<std::size_t>(r)]);
    all_.barrier.arrive_and_wait();
  }

  RanksTogether& all_;
  int rank_;
  std::vector<Parcel> expected_;
};

// work(ranks) once for each of so many ranks, side by side.
inline void on_ranks(int count, const std::function<void(Ranks&)>& work) {
  RanksTogether all(count);
  std::vector<std::thread> threads;
  for (int r = 0; r < count; ++r) {
    threads.emplace_back([&, r] {
      ThreadRanks ranks(all, r);
      work(ranks);
    });
  }
  for (std::thread& thread : threads) thread.join();
}

}  // namespace quoin
