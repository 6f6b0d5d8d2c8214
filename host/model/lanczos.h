// The largest eigenvalue of a symmetric operator that is known by its products only.
#pragma once

#include <functional>

#include "model/lanes.h"
#include "model/shared_model.h"

namespace quoin {

struct LanczosSettings {
  int max_steps = 0;
  int check_interval = 1;    // steps between two checks of the value
  int first_check = 0;       // steps before the value may count as settled
  double settled = 0.0;      // relative growth of the value between two checks
  bool with_vector = false;  // by a second sweep: twice the products
};

struct LargestEigenvalue {
  double value = 0.0;         // not a number if a product was not one
  LaneVector<double> vector;  // eigenvector of length 1; empty unless requested
  int steps = 0;
  int products = 0;
};

// y = A x; returns the scalar product of x and y, which costs little where y is formed.
using SymmetricProduct = std::function<double(const LaneVector<double>& x, LaneVector<double>* y)>;

// Lanczos iteration without reorthogonalisation. The largest Ritz value converges all the same, lost orthogonality only
// makes copies of it. start: of any length but 0, with a share of the eigenvector sought. The value is a lower bound to
// rounding. shared: who has only rows of each vector, as the product does; null: all of them. The bits are the same.
LargestEigenvalue largest_eigenvalue(const SymmetricProduct& product, LaneVector<double> start,
                                     const LanczosSettings& settings, SharedVectors* shared = nullptr);

}  // namespace quoin
