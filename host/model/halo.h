// Halo exchange: numbers that neighbouring ranks send each other in every step.
#pragma once

#include <cstddef>
#include <map>
#include <set>
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

// Keys of sides by rank: those that are sent to it, and those that are received from it.
template <class Key>
struct BorderKeys {
  std::map<int, std::set<Key>> to, from;
  // readers: ranks that evaluate contact points on this side. Returns whether this rank moves it.
  bool add(const Key& key, int owner, int here, const std::vector<int>& readers) {
    if (owner != here) return from[owner].insert(key), false;
    for (const int r : readers) {
      if (r != here) to[r].insert(key);
    }
    return true;
  }
  // add_numbers(key, list): adds the addresses of a side's numbers.
  template <class AddNumbers>
  Halo halo(int ranks, const AddNumbers& add_numbers) {
    Halo found;
    for (int r = 0; r < ranks; ++r) {
      Border border{r, {}, {}, {}, {}};
      for (const Key& key : to[r]) add_numbers(key, border.send);
      for (const Key& key : from[r]) add_numbers(key, border.receive);
      found.add(std::move(border));
    }
    return found;
  }
};

}  // namespace quoin
