#include "step/rank_arrays.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <span>

#include "base/rank_rows.h"
#include "base/ranks.h"
#include "model/world_parts.h"
#include "step/gather.h"
#include "step/state.h"

namespace quoin {

void give_array(Simulation::Impl& s, const void* array, std::size_t whole, const Simulation::TakeBytes& take) {
  struct Stretch {
    std::size_t begin, end;  // bytes from the beginning of the array
    int rank;
  };
  std::vector<Stretch> stretches;
  const auto* const first = static_cast<const std::uint8_t*>(array);
  const auto note = [&](int rank, const void* memory, std::size_t bytes) {
    const auto* const from = static_cast<const std::uint8_t*>(memory);
    if (from < first || from >= first + whole) return;
    const auto begin = static_cast<std::size_t>(from - first);
    if (!stretches.empty() && stretches.back().rank == rank && stretches.back().end == begin)
      stretches.back().end += bytes;
    else
      stretches.push_back({begin, begin + bytes, rank});
  };
  const auto note_of = [&](int rank) {
    return [&note, rank](const void* memory, std::size_t bytes) { note(rank, memory, bytes); };
  };
  if (s.large_motion) each_owned_memory(*s.large_motion, note);
  for (std::size_t i = 0; !s.large_motion && i < s.division.share.rank_of_item.size(); ++i)
    each_memory_of_item(s, Part::all, static_cast<int>(i), note_of(s.division.share.rank_of_item[i]));
  for (std::size_t c = 0; !s.large_motion && c < s.division.share.rank_of_chunk.size(); ++c)
    each_memory_of_chunk(s, Part::all, static_cast<int>(c), note_of(s.division.share.rank_of_chunk[c]));
  std::sort(stretches.begin(), stretches.end(), [](const Stretch& x, const Stretch& y) { return x.begin < y.begin; });

  const int here = s.ranks->rank();
  std::vector<std::size_t> sizes(at(s.ranks->count()));
  std::vector<std::uint8_t> own, all, piece;
  auto next = stretches.begin();
  for (std::size_t begin = 0; begin < whole; begin += kGatherBuffer) {
    const std::size_t end = std::min(begin + kGatherBuffer, whole);
    while (next != stretches.end() && next->end <= begin) ++next;
    const auto each_here = [&](const auto& visit) {
      for (auto i = next; i != stretches.end() && i->begin < end; ++i)
        visit(i->rank, std::max(i->begin, begin), std::min(i->end, end));
    };
    std::fill(sizes.begin(), sizes.end(), 0);
    own.clear();
    each_here([&](int rank, std::size_t from, std::size_t to) {
      sizes[at(rank)] += to - from;
      if (rank == here) own.insert(own.end(), first + from, first + to);
    });
    all.resize(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}));
    s.ranks->gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(all)));
    if (here != 0) continue;
    piece.assign(first + begin, first + end);
    std::vector<std::size_t> place(sizes.size());
    std::exclusive_scan(sizes.begin(), sizes.end(), place.begin(), std::size_t{0});
    each_here([&](int rank, std::size_t from, std::size_t to) {
      std::memcpy(piece.data() + (from - begin), all.data() + place[at(rank)], to - from);
      place[at(rank)] += to - from;
    });
    take(piece);
  }
}

}  // namespace quoin
