// Sums over a vector whose numbers ranks share, in the order of one process.
//
// Each rank tells all others its terms, a few megabytes of all ranks at a time, and everybody adds up all of them: so
// it takes as many messages however often numbers in a row change hands (step/rank_sums.h hands the sum on instead).
#pragma once

#include <vector>

#include "base/ranks.h"
#include "model/shared_model.h"

namespace quoin {

class ToldSums : public SharedVectors {
 public:
  explicit ToldSums(Ranks& ranks) : ranks_(ranks) {}

  void append(int rank, std::size_t numbers);  // the next ones of the vector, by the rank that computes them
  std::span<const VectorRow> rows() const override { return rows_; }
  double sum(const Add& add) override;

 private:
  struct Run {
    int rank;
    VectorRow row;
  };

  Ranks& ranks_;
  std::vector<Run> runs_;  // of all ranks, in order
  std::vector<VectorRow> rows_;
};

}  // namespace quoin
