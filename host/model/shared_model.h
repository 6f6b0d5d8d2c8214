// Vectors in generalised coordinates of a model that several processes share. Coordinates are gridpoints in lane
// layout, then 6 numbers a rigid body. A process has enough of them for K u and for sums in the order of a single
// process.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "base/ranks.h"
#include "model/lanes.h"

namespace quoin {

// Consecutive numbers of a vector.
struct VectorRow {
  std::size_t first, end;
};

// Runs of consecutive numbers that one rank computes.
struct RankRuns {
  struct Run {
    int rank;
    VectorRow row;
  };
  int here;                      // this rank
  std::vector<Run> all{};        // in order
  std::vector<VectorRow> own{};  // those of this rank
  void append(int rank, const VectorRow& row) {
    if (row.first == row.end) return;
    if (!all.empty() && all.back().rank == rank && all.back().row.end == row.first)
      all.back().row.end = row.end;
    else
      all.push_back({rank, row});
    if (rank != here) return;
    if (!own.empty() && own.back().end == row.first)
      own.back().end = row.end;
    else
      own.push_back(row);
  }
};

// Collective calls: all ranks make them in the same order.
class SharedVectors {
 public:
  using Add = std::function<double(const VectorRow& row, double sum)>;  // sum so far -> sum with this row

  virtual ~SharedVectors() = default;
  virtual std::span<const VectorRow> rows() const = 0;  // rows that this process computes, in order
  // Sum over the rows of all ranks in order, passed from rank to rank: the bits of a single process.
  virtual double sum(const Add& add) = 0;
};

// Sums in the order of a single process. All ranks gather all terms, a few megabytes at a time, and each adds up all of
// them. So the number of messages does not depend on how often consecutive numbers change rank. step/rank_sums.h passes
// the sum from rank to rank instead.
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

class SharedModel : public SharedVectors {
 public:
  virtual std::span<const int> units() const = 0;   // unit groups of this process, in order
  virtual std::span<const int> chunks() const = 0;  // chunks that touch these units or bodies of this process, in order
  // Sends numbers on borders from the processes that compute them to those that read them.
  virtual void exchange(LaneVector<double>& vector) = 0;
  // Replaces each value by its maximum over all processes.
  virtual void largest(std::span<double> values) = 0;
};

}  // namespace quoin
