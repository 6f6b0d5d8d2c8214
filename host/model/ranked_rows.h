// Rows of a vector by the rank that computes them: sums over all of it in the order of one process.
//
// A sum goes from the rank of the first rows to that of the next, and so on, as often as rows change hands: it takes as
// long as in one process, but no rank needs the numbers of another.
#pragma once

#include <vector>

#include "base/ranks.h"
#include "model/shared_model.h"

namespace quoin {

class RankedRows {
 public:
  explicit RankedRows(Ranks& ranks) : ranks_(ranks) {}

  void append(int rank, const VectorRow& row);               // in the order of sums
  std::span<const VectorRow> rows() const { return rows_; }  // of this rank
  double sum(const SharedVectors::Add& add);

 private:
  // Of one rank.
  struct Run {
    int rank;
    VectorRow row;
  };

  Ranks& ranks_;
  std::vector<Run> runs_;  // of all ranks
  std::vector<VectorRow> rows_;
};

}  // namespace quoin
