// Sums over a vector that is shared by ranks, in the order of a single process.
//
// All ranks gather all terms, a few megabytes at a time, and each rank adds up all of them. So the number of messages
// does not depend on how often consecutive numbers change rank. step/rank_sums.h passes the sum from rank to rank
// instead.
#pragma once

#include <vector>

#include "base/ranks.h"
#include "model/shared_model.h"

namespace quoin {

class GatheredSums : public SharedVectors {
 public:
  explicit GatheredSums(Ranks& ranks) : ranks_(ranks), runs_{ranks.rank()} {}

  void append(int rank, std::size_t numbers);  // appends the next numbers of the vector, which `rank` computes
  std::span<const VectorRow> rows() const override { return runs_.own; }
  double sum(const Add& add) override;

 private:
  Ranks& ranks_;
  RankRuns runs_;
};

}  // namespace quoin
