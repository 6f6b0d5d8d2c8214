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
  explicit GatheredSums(Ranks& ranks) : ranks_(ranks) {}

  void append(int rank, std::size_t numbers);  // appends the next numbers of the vector, which `rank` computes
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
