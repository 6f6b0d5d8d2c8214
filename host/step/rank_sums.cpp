#include "step/rank_sums.h"

#include <utility>

namespace quoin {

RankSums::RankSums(const Model& model, const RankShare& share, std::vector<int> units,
                   const std::vector<int>& rank_of_body, Ranks& ranks, std::function<Halo(LaneVector<double>&)> halo_of)
    : units_(std::move(units)), chunks_(share.chunks), ranks_(ranks), rows_(ranks), halo_of_(std::move(halo_of)) {
  for (std::size_t u = 0; u < model.unit_groups.size(); ++u) {
    const Model::Extent of = model.extent_of_units(u, u + 1);
    rows_.append(share.rank_of_item[u], {of.first_line * kLine, of.end_line * kLine});
  }
  auto first = static_cast<std::size_t>(model.line_count) * kLine;
  for (const int rank : rank_of_body) rows_.append(rank, {first, first + 6}), first += 6;
}

void RankSums::exchange(LaneVector<double>& vector) {
  if (exchanged_ != &vector) halo_ = halo_of_(vector), exchanged_ = &vector;
  halo_.send(ranks_);
  halo_.receive(ranks_);
}

}  // namespace quoin
