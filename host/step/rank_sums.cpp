#include "step/rank_sums.h"

#include <utility>

namespace quoin {

RankSums::RankSums(const Model& model, const RankShare& share, std::vector<int> units,
                   const std::vector<int>& rank_of_body, Ranks& ranks, std::function<Halo(LaneVector<double>&)> halo_of)
    : units_(std::move(units)), chunks_(share.chunks), ranks_(ranks), halo_of_(std::move(halo_of)) {
  for (std::size_t u = 0; u < model.unit_groups.size(); ++u) {
    const Model::Extent of = model.extent_of_units(u, u + 1);
    append(share.rank_of_item[u], {of.first_line * kLine, of.end_line * kLine});
  }
  auto first = static_cast<std::size_t>(model.line_count) * kLine;
  for (const int rank : rank_of_body) append(rank, {first, first + 6}), first += 6;
  for (const Run& run : runs_) {
    if (run.rank == ranks_.rank()) rows_.push_back(run.row);
  }
}

void RankSums::append(int rank, const VectorRow& row) {
  if (!runs_.empty() && runs_.back().rank == rank && runs_.back().row.end == row.first)
    runs_.back().row.end = row.end;
  else
    runs_.push_back({rank, row});
}

double RankSums::sum(const Add& add) {
  const int here = ranks_.rank();
  double so_far = 0.0;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].rank != here) continue;
    if (i > 0 && runs_[i - 1].rank != here) {
      const Ranks::Parcel from{runs_[i - 1].rank, {&so_far, 1}};
      ranks_.start({}, {&from, 1});
      ranks_.finish();
    }
    so_far = add(runs_[i].row, so_far);
    if (i + 1 < runs_.size() && runs_[i + 1].rank != here) {
      const Ranks::Parcel to{runs_[i + 1].rank, {&so_far, 1}};
      ranks_.start({&to, 1}, {});
      ranks_.finish();
    }
  }
  // The rank of the last run holds the whole sum.
  const int last = runs_.empty() ? 0 : runs_.back().rank;
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
