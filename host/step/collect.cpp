// Results of a model in parts, sent to rank 0 run by run: no rank holds all of them.
#include "step/collect.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <span>
#include <string_view>

#include "base/rank_rows.h"
#include "base/ranks.h"
#include "step/gather.h"
#include "step/rank_agreement.h"
#include "step/results.h"
#include "step/state.h"
#include "step/work_division.h"

namespace quoin {

namespace {

// Most blocks, points and joints of a run: about a megabyte of results.
constexpr std::int32_t kBlocks = 256, kPoints = 4096, kJoints = 1024;

// One process alone has no lists of ranks.
int rank_in(const std::vector<int>& ranks, std::size_t i) { return ranks.empty() ? 0 : ranks[i]; }

// Extends the last run to `end`, or begins another one.
void extend(std::vector<ResultRun>& runs, std::int32_t end, int rank, std::int32_t most) {
  const std::int32_t first = runs.empty() ? 0 : runs.back().end;
  if (runs.empty() || runs.back().rank != rank || end - runs.back().first > most)
    runs.push_back({first, end, rank});
  else
    runs.back().end = end;
}

// Messages consist of doubles.
std::vector<double> words_for(std::size_t bytes) {
  return std::vector<double>((bytes + sizeof(double) - 1) / sizeof(double));
}

void send_to_first(Ranks& ranks, std::string_view bytes) {
  double size = static_cast<double>(bytes.size());
  std::vector<double> words = words_for(bytes.size());
  if (!bytes.empty()) std::memcpy(words.data(), bytes.data(), bytes.size());
  for (const std::span<double> message : {std::span(&size, 1), std::span(words)}) {
    const Ranks::Parcel parcel{0, message};
    ranks.start({&parcel, 1}, {});
    ranks.finish();
  }
}

std::string receive_from(Ranks& ranks, int rank) {
  const auto receive = [&](std::span<double> message) {
    const Ranks::Parcel parcel{rank, message};
    ranks.start({}, {&parcel, 1});
    ranks.finish();
  };
  double size = 0.0;
  receive({&size, 1});
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::vector<double> words = words_for(bytes.size());
  receive(words);
  if (!bytes.empty()) std::memcpy(bytes.data(), words.data(), bytes.size());
  return bytes;
}

}  // namespace

// Each rank holds the results of its part until they are gathered.
bool ranks_collect(const Simulation::Impl& s) {
  return s.parts.divided && !s.parts.gathered && !s.parts.gathered_by_first;
}

std::vector<ResultRun> runs_of_blocks(const Simulation::Impl& s) {
  std::vector<ResultRun> runs;
  for (std::int32_t b = 0; b < block_count(s); ++b) {
    const int item = s.large_motion ? s.division.item_by_block[at(b)] : item_of_block(s, b);
    extend(runs, b + 1, rank_in(s.division.share.rank_of_item, at(item)), kBlocks);
  }
  return runs;
}

std::vector<ResultRun> runs_of_points(const Simulation::Impl& s) {
  std::vector<ResultRun> runs;
  const int chunks = s.large_motion ? s.large_motion->chunk_count() : static_cast<int>(s.model.chunks.size());
  for (int c = 0; c < chunks; ++c)
    extend(runs, points_of_chunk(s, c).end, rank_in(s.division.share.rank_of_chunk, at(c)), kPoints);
  return runs;
}

std::vector<ResultRun> runs_of_joints(const Simulation::Impl& s) {
  std::vector<ResultRun> runs;
  for (const Joint& joint : s.model.assembly.joints) {
    const auto end = static_cast<std::int32_t>(&joint - s.model.assembly.joints.data()) + 1;
    extend(runs, end, rank_in(s.division.share.rank_of_item, at(item_of_block(s, Model::sides_of(joint).a))), kJoints);
  }
  return runs;
}

bool brings(const Simulation::Impl& s, const ResultRun& run) {
  const int here = s.ranks ? s.ranks->rank() : 0;
  return ranks_collect(s) ? run.rank == here : here == 0;
}

void collect_at_first(const Simulation::Impl& s, std::span<const ResultRun> runs,
                      const std::function<std::string(const ResultRun&)>& make,
                      const std::function<void(const std::string&)>& take) {
  if (!s.ranks) {
    // Some threads make results while one takes those of the runs before.
    std::vector<std::string> before, made;
    do {
      const auto some = runs.first(std::min(runs.size(), static_cast<std::size_t>(s.pool.thread_count())));
      made.assign(some.size(), {});
      each_part(&s.pool, 1 + some.size(), 1, [&](std::size_t i, std::size_t) {
        if (i > 0)
          made[i - 1] = make(some[i - 1]);
        else
          std::ranges::for_each(before, take);
      });
      runs = runs.subspan(some.size());
      before.swap(made);
    } while (!before.empty());
    return;
  }
  const bool is_first = s.ranks->rank() == 0;
  for (const ResultRun& run : runs) {
    const bool here = brings(s, run);
    if (is_first) take(here ? make(run) : receive_from(*s.ranks, run.rank));
    if (here && !is_first) send_to_first(*s.ranks, make(run));
  }
}

double largest_brought(const Simulation::Impl& s, double brought) {
  return ranks_collect(s) ? largest_of_ranks(s, brought) : brought;
}

void gather_at_first(Simulation::Impl& s) { gather(s, Part::all, Who::first); }

double sum_brought(const Simulation::Impl& s, double brought) {
  if (!ranks_collect(s)) return brought;
  double sum = 0.0;
  for (const double x : of_all_ranks(*s.ranks, brought)) sum += x;
  return sum;
}

void each_own_point(const Simulation::Impl& s, const std::function<void(std::int32_t)>& visit) {
  if (s.large_motion)
    return each_chunk_in(s, all_points(s), [&](int index, const PointRange& of_chunk) {
      const blocks::Chunk& chunk = s.large_motion->chunks.all[at(index)];
      const blocks::Point* const point = &s.large_motion->contacts.families[at(chunk.family)].point[chunk.first];
      for (std::int32_t i = of_chunk.first; i < of_chunk.end; ++i)
        if (owns_block(s, point[i - of_chunk.first].a)) visit(i);
    });
  for (std::int32_t point = 0; point < s.model.point_count; ++point) {
    if (owns_block(s, s.model.sides_of(point).a)) visit(point);
  }
}

}  // namespace quoin
