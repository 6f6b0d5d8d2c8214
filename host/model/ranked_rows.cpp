#include "model/ranked_rows.h"

namespace quoin {

void RankedRows::append(int rank, const VectorRow& row) {
  if (!runs_.empty() && runs_.back().rank == rank && runs_.back().row.end == row.first)
    runs_.back().row.end = row.end;
  else
    runs_.push_back({rank, row});
  if (rank != ranks_.rank()) return;
  if (!rows_.empty() && rows_.back().end == row.first)
    rows_.back().end = row.end;
  else
    rows_.push_back(row);
}

double RankedRows::sum(const SharedVectors::Add& add) {
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
  // The last has all of it.
  const int last = runs_.empty() ? 0 : runs_.back().rank;
  std::vector<std::size_t> sizes(static_cast<std::size_t>(ranks_.count()), 0);
  sizes[static_cast<std::size_t>(last)] = sizeof so_far;
  double all = 0.0;
  const std::span<const double> own(&so_far, here == last ? 1 : 0);
  ranks_.gather(std::as_bytes(own), sizes, std::as_writable_bytes(std::span(&all, 1)));
  return all;
}

}  // namespace quoin
