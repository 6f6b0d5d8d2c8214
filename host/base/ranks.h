// Interface to the processes (ranks) that run one model together, independent of the message library.
#pragma once

#include <cstddef>
#include <span>

namespace quoin {

// Each process is a rank from 0 to count() - 1. All calls but start and finish are collective: all ranks make them in
// the same order. Calls come from one thread.
class Ranks {
 public:
  // Values of one message, and the rank at its other end.
  struct Parcel {
    int rank;
    std::span<double> values;
  };

  virtual ~Ranks() = default;
  virtual int rank() const = 0;
  virtual int count() const = 0;
  virtual int count_on_this_machine() const = 0;

  // Begins to send and to receive, one message per parcel, and returns. The values must stay in place until finish().
  virtual void start(std::span<const Parcel> send, std::span<const Parcel> receive) = 0;
  virtual void finish() = 0;

  // Replaces each value by its maximum over all ranks.
  virtual void largest(std::span<double> values) = 0;
  // Concatenates the bytes of all ranks. sizes: bytes of each rank, in sum the size of `all`.
  virtual void gather(std::span<const std::byte> own, std::span<const std::size_t> sizes, std::span<std::byte> all) = 0;
  // Sends the bytes of rank 0 to all.
  virtual void share(std::span<std::byte> bytes) = 0;
  // Whether all ranks make this call within this time, s. After false, only abort() may follow.
  virtual bool all_here(double seconds) = 0;
  // Ends all ranks with this exit code.
  [[noreturn]] virtual void abort(int exit_code) = 0;
};

}  // namespace quoin
