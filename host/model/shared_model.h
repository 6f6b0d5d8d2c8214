// What one of several processes has of vectors in generalised coordinates, and what it receives of the others. These
// are gridpoints in lane layout, then 6 numbers a rigid body. It is enough for K u and for sums in the order of one
// process.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "model/lanes.h"

namespace quoin {

// Neighbouring numbers of a vector.
struct VectorRow {
  std::size_t first, end;
};

// All calls that wait for others are made by all ranks in the same order.
class SharedVectors {
 public:
  using Add = std::function<double(const VectorRow& row, double sum)>;  // the sum so far to the sum with this row

  virtual ~SharedVectors() = default;
  virtual std::span<const VectorRow> rows() const = 0;  // rows that this process computes, in order
  // Over the rows of all ranks in order, handed from one to the next: the sum of one process, bit for bit.
  virtual double sum(const Add& add) = 0;
};

class SharedModel : public SharedVectors {
 public:
  virtual std::span<const int> units() const = 0;   // unit groups of this process, in order
  virtual std::span<const int> chunks() const = 0;  // all that touch them or bodies of this process, in order
  // Numbers on borders, of those who compute them to those who read them.
  virtual void exchange(LaneVector<double>& vector) = 0;
  // Number by number, the largest of all processes.
  virtual void largest(std::span<double> values) = 0;
};

}  // namespace quoin
