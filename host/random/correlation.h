// Correlated normal variables: of several quantities, and along a line.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "random/distribution.h"

namespace quoin::random {

// Lower triangle L, row by row, of L L^T = a matrix of correlations (n x n, row by row). L times independent standard
// normal variables has these correlations. Empty: the matrix is not positive definite.
std::vector<double> mix_of(const std::vector<double>& correlations, std::size_t n);

// Weights of the value at one place and of a new independent value in the value at the next place. Its distance is
// `distance` (m, >= 0), the correlation is exp(-distance/length). The squares of the weights sum to 1. For a length of
// 0 the new value alone counts, except at distance 0.
struct Follow {
  double share, fresh;
};
Follow follow(double distance, double length);

// Variance of the mean over an interval (m) of a field with this correlation, over that of a point. It is Vanmarcke's
// variance function, 2 (L/T)^2 (T/L - 1 + exp(-T/L)).
double variance_of_mean(double interval, double length);

// Distribution at points of a field whose mean over places x (m), with weights of sum 1, has the distribution
// `of_mean`. Its mean and shape are equal, its scatter is larger. For normal and lognormal distributions without
// bounds.
Distribution of_points(const Distribution& of_mean, double length, std::span<const double> x,
                       std::span<const double> weight);

}  // namespace quoin::random
