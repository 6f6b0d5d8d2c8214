// Ranks by MPI, in a library of its own. join.cpp loads it only where mpirun has started the program.
#include <mpi.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <stdexcept>
#include <vector>

#include "base/ranks.h"

namespace quoin {
namespace {

constexpr std::size_t kMost = std::size_t{1} << 30;  // largest number of bytes of one call: MPI counts in int

constexpr std::chrono::microseconds kSpin{100};  // longer than waits between ranks with cores of their own
constexpr useconds_t kNap = 20;                  // us

class MpiRanks : public Ranks {
 public:
  MpiRanks() {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm here;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &here);
    MPI_Comm_size(here, &count_here_);
    MPI_Comm_free(&here);
    MPI_Comm_dup(MPI_COMM_WORLD, &meeting_);
  }
  ~MpiRanks() override { MPI_Finalize(); }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  int rank() const override { return rank_; }
  int count() const override { return count_; }
  int count_on_this_machine() const override { return count_here_; }

  void start(std::span<const Parcel> send, std::span<const Parcel> receive) override {
    for (const Parcel& p : receive)
      MPI_Irecv(p.values.data(), size_of(p), MPI_DOUBLE, p.rank, 0, MPI_COMM_WORLD, &requests_.emplace_back());
    for (const Parcel& p : send)
      MPI_Isend(p.values.data(), size_of(p), MPI_DOUBLE, p.rank, 0, MPI_COMM_WORLD, &requests_.emplace_back());
  }
  void finish() override {
    wait(requests_);
    requests_.clear();
  }

  void largest(std::span<double> values) override {
    MPI_Request request;
    MPI_Iallreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_MAX, MPI_COMM_WORLD,
                   &request);
    wait({&request, 1});
  }

  void gather(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) override {
    if (all.size() <= kMost) {
      std::vector<int> counts, places;
      for (std::size_t place = 0; const std::size_t size : sizes) {
        counts.push_back(static_cast<int>(size)), places.push_back(static_cast<int>(place));
        place += size;
      }
      MPI_Request request;
      MPI_Iallgatherv(own.data(), static_cast<int>(own.size()), MPI_BYTE, all.data(), counts.data(), places.data(),
                      MPI_BYTE, MPI_COMM_WORLD, &request);
      wait({&request, 1});
      return;
    }
    std::size_t place = 0;
    for (int r = 0; r < count_; ++r) {
      const std::span<std::byte> part = all.subspan(place, sizes[static_cast<std::size_t>(r)]);
      if (r == rank_) std::copy(own.begin(), own.end(), part.begin());
      broadcast(part, r);
      place += part.size();
    }
  }

  void share(std::span<std::byte> bytes) override { broadcast(bytes, 0); }

  bool all_here(double seconds) override {
    MPI_Request request;
    MPI_Ibarrier(meeting_, &request);
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    for (int here = 0;;) {
      MPI_Test(&request, &here, MPI_STATUS_IGNORE);
      if (here) return true;
      if (std::chrono::steady_clock::now() > end) return false;
      usleep(1000);
    }
  }

  void abort(int exit_code) override {
    MPI_Abort(MPI_COMM_WORLD, exit_code);
    std::_Exit(exit_code);
  }

 private:
  // MPI_Wait keeps its core busy. Where ranks share cores, the rank it waits for would then get no time.
  static void wait(std::span<MPI_Request> requests) {
    const auto patience = std::chrono::steady_clock::now() + kSpin;
    for (int done = 0;;) {
      MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE);
      if (done) return;
      if (std::chrono::steady_clock::now() > patience) usleep(kNap);
    }
  }
  static int size_of(const Parcel& p) {
    if (p.values.size() > INT_MAX) throw std::length_error("a message to another rank is too long; use more ranks");
    return static_cast<int>(p.values.size());
  }
  static void broadcast(std::span<std::byte> bytes, int from) {
    for (std::size_t place = 0; place < bytes.size(); place += kMost) {
      const std::span<std::byte> part = bytes.subspan(place, std::min(kMost, bytes.size() - place));
      MPI_Bcast(part.data(), static_cast<int>(part.size()), MPI_BYTE, from, MPI_COMM_WORLD);
    }
  }

  int rank_ = 0, count_ = 1, count_here_ = 1;
  MPI_Comm meeting_ = MPI_COMM_NULL;  // for ranks in all_here, while others may be in other calls
  std::vector<MPI_Request> requests_;
};

}  // namespace
}  // namespace quoin

// Created by new; the caller owns it.
extern "C" quoin::Ranks* quoin_join_ranks() { return new quoin::MpiRanks; }
