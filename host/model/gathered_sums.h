// Sums over a vector whose numbers ranks share, in the order of one process.
//
// All ranks gather all terms, a few megabytes at a time, and each adds up all of them. So the number of messages does
// not depend on how often numbers in a row change their rank. step/rank_sums.h hands the sum on instead.
#pragma once

#include <vector>

#include "base/ranks.h"
#include "model/shared_model.h"

namespace quoin {

class GatheredSums : public SharedVectors {
 public:
  explicit GatheredSums(Ranks& ranks) : ranks_(ranks) {}

  void append(int rank, std::size_t numbers);  // the next ones of the vector, by the rank that computes them
  std::span<const VectorRow> rows() const override { return rows_; }
  double sum(const Add& add) override;

 private:
  struct Run {
    int rank;
    VectorRow row;
  };

  Ranks& ranks_;
  std::vector<Run> runs_;  // runs of all ranks, in order
  std::vector<VectorRow> rows_;
};

}  // namespace quoin
