// Sums over vectors of a model that ranks hold in parts, in the order of one process.
//
// The partial sum over one run of items is sent to the rank of the next run. It takes as long as in one process, but no
// rank needs the values of another.
#pragma once

#include <vector>

#include "model/model.h"
#include "model/shared_model.h"
#include "step/rank_share.h"

namespace quoin {

class RankSums : public SharedModel {
 public:
  // units: unit groups of this rank, ascending. halo_of: exchange from ranks that compute values of a vector to ranks
  // that read them.
  RankSums(const Model& model, const RankShare& share, std::vector<int> units, const std::vector<int>& rank_of_body,
           Ranks& ranks, std::function<Halo(LaneVector<double>&)> halo_of);

  std::span<const VectorRow> rows() const override { return runs_.own; }
  double sum(const Add& add) override;
  std::span<const int> units() const override { return units_; }
  std::span<const int> chunks() const override { return chunks_; }
  void exchange(LaneVector<double>& vector) override;
  void largest(std::span<double> values) override { ranks_.largest(values); }

 private:
  RankRuns runs_;
  std::vector<int> units_, chunks_;
  Ranks& ranks_;
  std::function<Halo(LaneVector<double>&)> halo_of_;
  Halo halo_;
  const double* numbers_ = nullptr;  // data of the vector to which halo_ is bound
};

}  // namespace quoin
