// Exchange of memory between ranks, some megabytes at a time, as it may be most of the model.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include "base/ranks.h"

namespace quoin {

// Parts of a model that ranks gather in steps. Each includes those before it, except `motion`, which has no sums.
enum class Part {
  sums,    // sums of a measured step
  motion,  // motion of blocks for detection, in large motion alone
  row,     // sums and motion; values of contact points for a row of history.csv
  all,     // everything that steps change and that later steps or results read
  nothing  // fields that are in none of these
};
constexpr bool has(Part part, Part field) { return field <= part && (part != Part::motion || field == Part::motion); }

// Bytes of all ranks together in one message.
inline constexpr std::size_t kGatherBuffer = std::size_t{4} << 20;

// Memory by the rank that owns it. All ranks add the same items in the same order.
class RankRows {
 public:
  explicit RankRows(Ranks& ranks) : ranks_(ranks), of_rank_(static_cast<std::size_t>(ranks.count())) {}

  // The last argument: whether this rank receives the bytes of another rank.
  void add(int rank, void* first, std::size_t bytes, bool wanted) {
    Row& row = of_rank_[static_cast<std::size_t>(rank)];
    row.parts.push_back({{static_cast<std::byte*>(first), bytes}, wanted});
    row.rest += bytes;
  }

  // Sends all bytes to the ranks that receive them. Returns the bytes of all ranks.
  std::size_t exchange() {
    std::size_t whole = 0, longest = 0;
    for (const Row& row : of_rank_) whole += row.rest, longest = std::max(longest, row.rest);
    const std::size_t most = std::max(kGatherBuffer / of_rank_.size(), std::size_t{1});
    const auto here = static_cast<std::size_t>(ranks_.rank());
    std::vector<std::size_t> sizes(of_rank_.size());
    std::vector<std::byte> own, all;
    for (std::size_t done = 0; done < longest; done += most) {
      std::size_t on_their_way = 0;
      for (std::size_t r = 0; r < of_rank_.size(); ++r) on_their_way += sizes[r] = std::min(most, of_rank_[r].rest);
      own.resize(sizes[here]), all.resize(on_their_way);
      of_rank_[here].each(own.size(), [to = own.data()](const std::byte* place, std::size_t bytes, bool) mutable {
        std::memcpy(to, place, bytes);
        to += bytes;
      });
      ranks_.gather(own, sizes, all);
      const std::byte* from = all.data();
      for (std::size_t r = 0; r < of_rank_.size(); from += sizes[r++]) {
        if (r == here) continue;
        of_rank_[r].each(sizes[r], [there = from](std::byte* place, std::size_t bytes, bool wanted) mutable {
          if (wanted) std::memcpy(place, there, bytes);
          there += bytes;
        });
      }
    }
    return whole;
  }

 private:
  struct Memory {
    std::span<std::byte> bytes;
    bool wanted;
  };
  // Memory of one rank, sent some bytes at a time.
  struct Row {
    std::vector<Memory> parts;
    std::size_t next = 0, rest = 0;

    template <class Visit>
    void each(std::size_t bytes, Visit visit) {
      rest -= bytes;
      while (bytes > 0) {
        auto& [memory, wanted] = parts[next];
        const std::size_t count = std::min(bytes, memory.size());
        visit(memory.data(), count, wanted);
        memory = memory.subspan(count);
        bytes -= count;
        if (memory.empty()) ++next;
      }
    }
  };

  Ranks& ranks_;
  std::vector<Row> of_rank_;
};

// Values of all ranks, by rank.
template <class T>
std::vector<T> of_all_ranks(Ranks& ranks, const T& own) {
  static_assert(std::is_trivially_copyable_v<T>);
  std::vector<T> all(static_cast<std::size_t>(ranks.count()));
  const std::vector<std::size_t> sizes(all.size(), sizeof own);
  ranks.gather(std::as_bytes(std::span(&own, 1)), sizes, std::as_writable_bytes(std::span(all)));
  return all;
}

// Gives all ranks each value from the rank that owns it: rank_of(index). null: a single process, which has all values.
template <class T, class RankOf>
void all_gather(Ranks* ranks, std::span<T> values, const RankOf& rank_of) {
  if (!ranks) return;
  std::vector<std::size_t> sizes(static_cast<std::size_t>(ranks->count()), 0);
  std::vector<T> own, all(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const int rank = rank_of(i);
    sizes[static_cast<std::size_t>(rank)] += sizeof(T);
    if (rank == ranks->rank()) own.push_back(values[i]);
  }
  ranks->gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(all)));
  std::vector<std::size_t> next(sizes.size(), 0);
  for (std::size_t r = 1; r < sizes.size(); ++r) next[r] = next[r - 1] + sizes[r - 1] / sizeof(T);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = all[next[static_cast<std::size_t>(rank_of(i))]++];
}

}  // namespace quoin
