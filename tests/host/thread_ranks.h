// Ranks that are threads of one process, for tests of ranks without MPI.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "base/ranks.h"

namespace quoin {

class ThreadRanks : public Ranks {
 public:
  // Data that all ranks share. When a rank ends, ranks that wait for it throw.
  struct Shared {
    explicit Shared(int ranks) : count(ranks), left(ranks), slot(static_cast<std::size_t>(ranks)) {}
    const int count;
    int left;
    long rounds = 0;
    bool ended = false;
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::vector<std::byte>> slot;                             // bytes of each rank in a round
    std::map<std::pair<int, int>, std::deque<std::vector<double>>> mail;  // by (sender, receiver)
    long messages = 0;
  };

  ThreadRanks(Shared* shared, int rank) : shared_(*shared), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return shared_.count; }
  int count_on_this_machine() const override { return shared_.count; }

  void start(std::span<const Parcel> send, std::span<const Parcel> receive) override {
    const std::lock_guard lock(shared_.mutex);
    for (const Parcel& p : send) {
      shared_.mail[{rank_, p.rank}].emplace_back(p.values.begin(), p.values.end());
      ++shared_.messages;
    }
    expected_.assign(receive.begin(), receive.end());
    shared_.changed.notify_all();
  }
  void finish() override {
    for (const Parcel& p : expected_) {
      std::unique_lock lock(shared_.mutex);
      auto& box = shared_.mail[{p.rank, rank_}];
      wait(lock, [&] { return !box.empty(); });
      if (box.front().size() != p.values.size()) throw std::logic_error("a message of another length than expected");
      std::copy(box.front().begin(), box.front().end(), p.values.begin());
      box.pop_front();
    }
    expected_.clear();
  }

  void largest(std::span<double> values) override {
    const auto all = meet(std::as_bytes(values));
    for (const auto& bytes : all) {
      if (bytes.size() != values.size_bytes()) throw std::logic_error("ranks compare lists of different lengths");
      for (std::size_t i = 0; i < values.size(); ++i) {
        double value;
        std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
        values[i] = std::max(values[i], value);
      }
    }
  }
  void gather(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
    const auto parts = meet(own);
    std::size_t place = 0;
    for (std::size_t r = 0; r < parts.size(); ++r) {
      if (parts[r].size() != sizes[r]) throw std::logic_error("a rank gathers more or less than it was said to");
      std::copy(parts[r].begin(), parts[r].end(), all.begin() + static_cast<std::ptrdiff_t>(place));
      place += sizes[r];
    }
  }
  void share(std::span<std::byte> bytes) override {
    const auto all = meet(bytes);
    std::copy(all[0].begin(), all[0].end(), bytes.begin());
  }
  bool all_here(double) override {
    try {
      meet({});
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  }
  [[noreturn]] void abort(int) override {
    end();
    throw std::runtime_error("aborted");
  }
  void end() {
    const std::lock_guard lock(shared_.mutex);
    shared_.ended = true;
    shared_.changed.notify_all();
  }

 private:
  template <class Done>
  void wait(std::unique_lock<std::mutex>& lock, const Done& done) {
    const bool in_time =
        shared_.changed.wait_for(lock, std::chrono::seconds(60), [&] { return shared_.ended || done(); });
    if (!done()) throw std::runtime_error(in_time ? "another rank has ended" : "ranks wait for each other for ever");
  }

  // Waits for all ranks and returns the bytes of every rank.
  std::vector<std::vector<std::byte>> meet(std::span<const std::byte> own) {
    std::unique_lock lock(shared_.mutex);
    shared_.slot[static_cast<std::size_t>(rank_)].assign(own.begin(), own.end());
    arrive(lock);
    const auto all = shared_.slot;
    arrive(lock);  // the next round begins when all have read
    return all;
  }
  void arrive(std::unique_lock<std::mutex>& lock) {
    const long round = shared_.rounds;
    if (--shared_.left == 0) {
      shared_.left = shared_.count;
      ++shared_.rounds;
      shared_.changed.notify_all();
      return;
    }
    wait(lock, [&] { return shared_.rounds != round; });
  }

  Shared& shared_;
  const int rank_;
  std::vector<Parcel> expected_;
};

// Runs `of_rank` on `count` ranks at the same time and throws the first exception of any of them. Returns the number of
// messages between ranks.
inline long on_ranks(int count, const std::function<void(Ranks&)>& of_rank) {
  ThreadRanks::Shared shared(count);
  std::vector<std::exception_ptr> faults(static_cast<std::size_t>(count));
  std::vector<std::jthread> threads;
  for (int r = 0; r < count; ++r) {
    threads.emplace_back([&, r] {
      ThreadRanks ranks(&shared, r);
      try {
        of_rank(ranks);
      } catch (...) {
        faults[static_cast<std::size_t>(r)] = std::current_exception();
        ranks.end();
      }
    });
  }
  threads.clear();
  for (const auto& fault : faults) {
    if (fault) std::rethrow_exception(fault);
  }
  return shared.messages;
}

}  // namespace quoin
