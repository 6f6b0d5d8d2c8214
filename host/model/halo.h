// Halo exchange: numbers that neighbouring ranks send each other in every step.
#pragma once

#include <cstddef>
#include <vector>

#include "base/ranks.h"

namespace quoin {

// Motion that two ranks exchange after every step: addresses of its numbers, in the same order on both sides.
struct Border {
  int rank;
  std::vector<double*> send, receive;
  std::vector<double> outgoing, incoming;
};

// One message each way with every rank that shares a border.
class Halo {
 public:
  void clear() { borders_.clear(); }
  void add(Border border);
  void send(Ranks& ranks);                               // also begins to receive; returns at once
  void receive(Ranks& ranks);                            // waits
  std::size_t messages() const { return send_.size(); }  // messages that this rank sends
  std::size_t bytes() const;                             // bytes of these messages

 private:
  std::vector<Border> borders_;
  std::vector<Ranks::Parcel> send_, receive_;
};

}  // namespace quoin
