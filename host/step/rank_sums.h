// Vectors of a model whose items ranks share, with sums over all of them in the order of one process.
#pragma once

#include <vector>

#include "model/model.h"
#include "model/ranked_rows.h"
#include "model/shared_model.h"
#include "step/rank_share.h"

namespace quoin {

class RankSums : public SharedModel {
 public:
  // units: of this rank, in order. halo_of: between those who compute the numbers of a vector and who reads them.
  RankSums(const Model& model, const RankShare& share, std::vector<int> units, const std::vector<int>& rank_of_body,
           Ranks& ranks, std::function<Halo(LaneVector<double>&)> halo_of);

  std::span<const VectorRow> rows() const override { return rows_.rows(); }
  double sum(const Add& add) override { return rows_.sum(add); }
  std::span<const int> units() const override { return units_; }
  std::span<const int> chunks() const override { return chunks_; }
  void exchange(LaneVector<double>& vector) override;

 private:
  std::vector<int> units_, chunks_;
  Ranks& ranks_;
  RankedRows rows_;
  std::function<Halo(LaneVector<double>&)> halo_of_;
  Halo halo_;
  const LaneVector<double>* exchanged_ = nullptr;
};

}  // namespace quoin
