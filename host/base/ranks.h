// Processes that run one model together: what the step needs of them, and nothing of the library beneath.
#pragma once

#include <cstddef>
#include <span>

namespace quoin {

// Each process is a rank from 0 to count() - 1. All calls but those of start and finish are made by all ranks in the
// same order, and wait for all. Calls come from one thread.
class Ranks {
 public:
  // Where numbers go to or come from.
  struct Parcel {
    int rank;
    std::span<double> values;
  };

  virtual ~Ranks() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;
  virtual int count_on_this_machine() const = 0;

  // Begins to send and to receive, one message a parcel, and returns. What the parcels name must stay until finish().
  virtual void start(std::span<const Parcel> send, std::span<const Parcel> receive) = 0;
  virtual void finish() = 0;

  // Number by number, the largest of all ranks.
  virtual void largest(std::span<double> values) = 0;
  // What each rank has, one after the other. sizes: bytes of each rank, in sum the size of `all`.
  virtual void gather(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) = 0;
  // Sends the bytes of rank 0 to all.
  virtual void share(std::span<std::byte> bytes) = 0;
  // Whether all ranks come here within so many seconds. Where they did not, nothing else may follow but abort().
  virtual bool all_here(double seconds) = 0;
  // Ends all of them with this exit code.
  [[noreturn]] virtual void abort(int exit_code) = 0;
};

}  // namespace quoin
