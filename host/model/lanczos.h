// Largest eigenvalue of a symmetric operator that is given by its products.
#pragma once

#include <functional>

#include "model/lanes.h"
#include "model/shared_model.h"

namespace quoin {

struct LanczosSettings {
  int max_steps = 0;
  int check_interval = 1;    // steps between two checks of the value
  int first_check = 0;       // steps before the value may count as converged
  double settled = 0.0;      // relative growth of the value between two checks below which it has converged
  bool with_vector = false;  // whether to compute the eigenvector, by a second sweep: twice the products
};

struct LargestEigenvalue {
  double value = 0.0;         // not a number if a product was not one
  LaneVector<double> vector;  // eigenvector of length 1; empty unless requested
  int steps = 0;
  int products = 0;
};

// y = A x; returns the scalar product of x and y, which costs little where y is formed.
using SymmetricProduct = std::function<double(const LaneVector<double>& x, LaneVector<double>* y)>;

// Lanczos iteration without reorthogonalisation: the largest Ritz value converges all the same, as lost orthogonality
// only makes copies of it. start: nonzero, with a component along the eigenvector. The value is a lower bound to
// rounding. shared: for processes that have only rows of each vector, as the product does; null: one process. The bits
// are the same.
LargestEigenvalue largest_eigenvalue(const SymmetricProduct& product, LaneVector<double> start,
                                     const LanczosSettings& settings, SharedVectors* shared = nullptr);

}  // namespace quoin
