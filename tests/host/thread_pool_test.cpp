// Every piece of every call runs exactly once, for any delays of the threads.
#include "base/thread_pool.h"

#include <gtest/gtest.h>

#include <chrono>
#include <random>

namespace quoin {
namespace {

// Returns the ends of the ranges of the threads.
std::vector<int> ends_of(int threads, int pieces) {
  std::vector<int> end;
  for (int t = 1; t <= threads; ++t) end.push_back(pieces * t / threads);
  return end;
}

TEST(ThreadPool, SharesAreOfEqualWeight) {
  EXPECT_EQ(shares({1, 1, 1, 1, 1, 1}, 3), (std::vector<int>{2, 4, 6}));
  EXPECT_EQ(shares({3, 1, 1, 1}, 2), (std::vector<int>{1, 4}));
  EXPECT_EQ(shares({1, 1, 1, 3, 3, 3}, 4), (std::vector<int>{3, 4, 5, 6}));
  EXPECT_EQ(shares({}, 2), (std::vector<int>{0, 0}));
}

TEST(ThreadPool, EveryPieceOnceInCallsOfAnyLength) {
  for (const int threads : {1, 2, 3, 8}) {  // also more threads than cores, which start late
    ThreadPool pool(threads);
    std::mt19937 random(5);
    std::uniform_int_distribution<int> length(0, 40);
    long calls = 0;
    for (int i = 0; i < 3000; ++i, ++calls) {
      const int pieces = length(random);
      const std::vector<int> end = ends_of(threads, pieces);  // freed after the call, as the function is
      std::vector<int> times(static_cast<std::size_t>(pieces), 0);
      auto count = [&](int thread, int piece) {
        ASSERT_TRUE(thread >= 0 && thread < threads);
        ASSERT_TRUE(piece >= 0 && piece < pieces);
        ++times[static_cast<std::size_t>(piece)];
      };
      pool.for_each(end, count);
      for (const int n : times) ASSERT_EQ(n, 1) << "threads " << threads << ", call " << calls;
    }
  }
}

// A call reads what an earlier call has written, on any thread.
TEST(ThreadPool, CallsSeeWhatEarlierCallsWrote) {
  constexpr int kPieces = 24;
  ThreadPool pool(4);
  const std::vector<int> end = ends_of(4, kPieces);
  std::vector<long> here(kPieces, 1), there(kPieces, 0);
  for (int i = 0; i < 2000; ++i) {
    auto shift = [&](int, int piece) {
      there[static_cast<std::size_t>(piece)] = here[static_cast<std::size_t>((piece + 1) % kPieces)] + 1;
    };
    pool.for_each(end, shift);
    here.swap(there);
  }
  for (const long value : here) EXPECT_EQ(value, 2001);
}

// A thread that is delayed in its first piece computes only this one; another thread computes the rest of its range.
TEST(ThreadPool, AThreadThatIsHeldUpLosesItsShareToOthers) {
  ThreadPool pool(2);
  std::vector<int> by(20, -1);
  std::atomic<int> others{0};
  auto work = [&](int thread, int piece) {
    by[static_cast<std::size_t>(piece)] = thread;
    if (piece != 10) {
      ++others;
      return;
    }
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (others < 19 && std::chrono::steady_clock::now() < give_up) std::this_thread::yield();
  };
  pool.for_each(ends_of(2, 20), work);
  const int held_up = by[10];
  for (std::size_t piece = 11; piece < 20; ++piece) EXPECT_EQ(by[piece], 1 - held_up) << piece;
}

}  // namespace
}  // namespace quoin
