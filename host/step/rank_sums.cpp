#include "step/rank_sums.h"

#include <utility>

namespace quoin {

RankSums::RankSums(const Model& model, const RankShare& share, std::vector<int> units,
                   const std::vector<int>& rank_of_body, Ranks& ranks, std::function<Halo(LaneVector<double>&)> halo_of)
    : runs_{ranks.rank()},
      units_(std::move(units)),
      chunks_(share.chunks),
      ranks_(ranks),
      halo_of_(std::move(halo_of)) {
  for (std::size_t u = 0; u < model.unit_groups.size(); ++u) {
    const Model::Extent of = model.extent_of_units(u, u + 1);
    runs_.append(share.rank_of_item[u], {of.first_line * kLine, of.end_line * kLine});
  }
  auto first = static_cast<std::size_t>(model.line_count) * kLine;
  for (const int rank : rank_of_body) runs_.append(rank, {first, first + 6}), first += 6;
}

double RankSums::sum(const Add& add) {
  const int here = ranks_.rank();
  const std::vector<RankRuns::Run>& runs = runs_.all;
  double so_far = 0.0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].rank != here) continue;
    if (i > 0 && runs[i - 1].rank != here) {
      const Ranks::Parcel from{runs[i - 1].rank, {&so_far, 1}};
      ranks_.start({}, {&from, 1});
      ranks_.finish();
    }
    so_far = add(runs[i].row, so_far);
    if (i + 1 < runs.size() && runs[i + 1].rank != here) {
      const Ranks::Parcel to{runs[i + 1].rank, {&so_far, 1}};
      ranks_.start({&to, 1}, {});
      ranks_.finish();
    }
  }
  // The rank of the last run holds the whole sum.
  const int last = runs.empty() ? 0 : runs.back().rank;
  std::vector<std::size_t> sizes(static_cast<std::size_t>(ranks_.count()), 0);
  sizes[static_cast<std::size_t>(last)] = sizeof so_far;
  double all = 0.0;
  const std::span<const double> own(&so_far, here == last ? 1 : 0);
  ranks_.gather(std::as_bytes(own), sizes, std::as_writable_bytes(std::span(&all, 1)));
  return all;
}

void RankSums::exchange(LaneVector<double>& vector) {
  if (numbers_ != vector.data()) halo_ = halo_of_(vector), numbers_ = vector.data();
  halo_.send(ranks_);
  halo_.receive(ranks_);
}

}  // namespace quoin
